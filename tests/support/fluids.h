// Fluids for tests: particles at given places, and the lists of neighbours that a step found.
#pragma once

#include "engine/solver/fluid.h"
#include "tests/support/bodies.h"

#include <algorithm>

namespace pliant::test {

inline Material water() {
  Material made;
  made.name = "water";
  made.model = "fluid";
  return made;
}

/// A fluid of one material without gravity, its particles exactly at `points`.
inline Stage fluid_stage(const Points& points, double spacing, double step, unsigned dimension = 3) {
  Stage stage(points, spacing, water(), step);
  stage.scene.bodies.emplace_back().material = "water";
  stage.scene.simulation.dimension = stage.model.dimension = dimension;
  if (dimension == 2)
    for (double& mass : stage.model.mass) mass = 1000 * spacing * spacing;
  for (std::size_t i = 0; i < points.size(); ++i) stage.model.position[i] = points[stage.model.id[i]];
  return stage;
}

inline void repeat(Scene& scene, const Vector3& low, const Vector3& high, std::array<bool, 3> periodic) {
  scene.domain = {true, low, high, periodic};
}

/// The shortest of a difference's images.
inline Vector3 image(const Scene& scene, Vector3 d) {
  for (int a = 0; a < 3; ++a) {
    const double period = scene.domain.high[a] - scene.domain.low[a];
    if (scene.domain.given && scene.domain.periodic[static_cast<std::size_t>(a)])
      d[a] -= period * std::round(d[a] / period);
  }
  return d;
}

/// For each particle its neighbours, ascending, as the last step listed them.
inline std::vector<std::vector<std::uint32_t>> neighbour_lists(Simulation& simulation) {
  const Fluid& fluid = *simulation.fluid();
  Device& device = simulation.device();
  const auto particle = device.download_uint(fluid.buffer("fluid_particle")),
             count = device.download_uint(fluid.buffer("near_count")),
             near = device.download_uint(fluid.buffer("near"));
  std::vector<std::vector<std::uint32_t>> lists(particle.size());
  const std::uint32_t rows = fluid.plan().model.rows;
  for (std::uint32_t place = 0; place < particle.size(); ++place) {
    auto& list = lists[particle[place]];
    for (std::uint32_t r = 0; r < count[place / 16]; ++r) {
      const std::uint32_t other = near[std::size_t{16} * (rows * (place / 16) + r) + place % 16];
      if (other != place) list.push_back(particle[other]);
    }
    std::sort(list.begin(), list.end());
  }
  return lists;
}

} // namespace pliant::test
