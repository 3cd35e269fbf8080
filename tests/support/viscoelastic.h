// Matter that flows and has bonds, for tests: stages, and the stress that its bonds bear.
#pragma once

#include "engine/model/fluid_bonds.h"
#include "shaders/common/fluid_bond.glsl"
#include "tests/support/fluids.h"

namespace pliant::test {

inline Material viscoelastic(double young, double poisson) {
  Material made;
  made.name = "clay";
  made.model = "viscoelastic";
  made.young = young;
  made.poisson = poisson;
  return made;
}
inline Material yielding(Material made, double cohesion, double friction_degrees = 0, double hardening = 0) {
  made.plastic = {true, cohesion, friction_degrees * std::acos(-1.0) / 180, hardening};
  return made;
}

/// One body without gravity, its particles exactly at `points`.
inline Stage bonded_stage(const Points& points, double spacing, double step, const Material& material) {
  Stage stage(points, spacing, material, step);
  stage.scene.bodies.emplace_back().material = material.name;
  for (std::size_t i = 0; i < points.size(); ++i) stage.model.position[i] = points[stage.model.id[i]];
  return stage;
}

/// Every bond of the last step, once from each end: particles, y from i to j at the end of the step, its rest
/// length and its weight.
struct FluidBond {
  std::uint32_t i = 0, j = 0;
  Vector3 y = Vector3::Zero();
  double rest = 0, weight = 0;
};
inline std::vector<FluidBond> bonds_of(Simulation& simulation, const Stage& stage) {
  const Fluid& fluid = *simulation.fluid();
  Device& device = simulation.device();
  const auto particle = device.download_uint(fluid.buffer("fluid_particle")),
             count = device.download_uint(fluid.buffer("near_count")),
             near = device.download_uint(fluid.buffer("near"));
  const auto rest = device.download_real(fluid.buffer("near_rest"));
  const auto start = device.download_real4(fluid.buffer("fluid_start")),
             place = device.download_real4(fluid.buffer("fluid_place"));
  const FluidModel& model = fluid.plan().model;
  const auto between = [&](const std::vector<Real4<double>>& at, std::size_t a, std::size_t b) {
    return image(stage.scene, Vector3(at[b].x - at[a].x, at[b].y - at[a].y, at[b].z - at[a].z));
  };
  std::vector<FluidBond> bonds;
  for (std::uint32_t a = 0; a < particle.size(); ++a)
    for (std::uint32_t r = 0; r < count[a / 16]; ++r) {
      const std::size_t entry = std::size_t{16} * (model.rows * (a / 16) + r) + a % 16;
      if (!(rest[entry] > 0)) continue;
      const std::uint32_t b = near[entry];
      const double q = between(start, a, b).squaredNorm() / (model.reach * model.reach);
      bonds.push_back(
          {particle[a], particle[b], between(place, a, b), rest[entry], bond_weight(fluid.plan().bonds, q)});
    }
  return bonds;
}

/// Stress of the chosen particles, Pa, tension positive: 1/V sum f (x) y over bonds, half of each at either
/// end. Of one material, after what flows has flowed.
inline Matrix3 stress_of(Simulation& simulation, const Stage& stage,
                         const std::function<bool(const Vector3&)>& chosen) {
  const std::vector<FluidBond> bonds = bonds_of(simulation, stage);
  const FluidElasticity& matter = simulation.fluid()->plan().bonds.materials.at(0);
  const std::size_t n = stage.model.count();
  std::vector<double> sum(n, 0), mean(n, 0), k(n, 0);
  for (const FluidBond& bond : bonds) {
    sum[bond.i] += bond.weight;
    mean[bond.i] += bond.weight * (bond.y.norm() / bond.rest - 1);
  }
  for (std::size_t i = 0; i < n; ++i)
    if (sum[i] > 0) mean[i] /= sum[i], k[i] = matter.bond / std::max(sum[i], FULL_BONDS);
  const Points at = simulation.positions();
  Matrix3 stress = Matrix3::Zero();
  double volume = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (chosen(at[i])) volume += std::pow(stage.model.spacing, 3);
  for (const FluidBond& bond : bonds) {
    if (!chosen(at[bond.i])) continue;
    const double e = bond.y.norm() / bond.rest - 1;
    const double pull = bond.weight / bond.rest *
                        (k[bond.i] * (e + (matter.volumetric - 1) * mean[bond.i]) +
                         k[bond.j] * (e + (matter.volumetric - 1) * mean[bond.j]));
    stress += 0.5 * pull / bond.y.norm() * bond.y * bond.y.transpose() / volume;
  }
  return stress;
}

} // namespace pliant::test
