// Scenes of examples/, with keys set anew, and what their checks measure.
#pragma once

#include "engine/scene/mesh.h"
#include "engine/scene/scene_parse.h"
#include "tests/support/bodies.h"

#include <filesystem>

namespace pliant::test {

inline Scene example_scene(const std::string& name, const std::vector<std::string>& overrides) {
  return read_scene(std::filesystem::path(PLIANT_SOURCE_DIR) / "examples" / (name + ".toml"), overrides);
}

/// The first mesh of the scene that is not on this machine; empty where all are.
inline std::string missing_mesh(const Scene& scene) {
  for (const Body& body : scene.bodies)
    if (body.shape.kind == Shape::Kind::mesh) try {
        find_mesh(body.shape.mesh, scene.file.parent_path());
      } catch (const Error&) {
        return body.shape.mesh;
      }
  return "";
}

/// To the scene's end; `each` is called after every step.
inline Points run_scene(Simulation& simulation, const Scene& scene,
                        const std::function<void(const Points&)>& each = {}) {
  const auto steps = std::lround(scene.simulation.end / simulation.time_step());
  for (long k = 0; k < steps; ++k) {
    simulation.step();
    if (each) each(simulation.positions());
  }
  return simulation.positions();
}

/// Mean of b - a over a body's particles at whose rest positions `where` holds.
inline Vector3 mean_shift(
    const Model& model, std::size_t body, const Points& a, const Points& b,
    const Where& where = [](const Vector3&) { return true; }) {
  const BodyModel& its = model.bodies[body];
  Vector3 sum = Vector3::Zero();
  double count = 0;
  for (std::uint32_t i = its.first; i < its.first + its.count; ++i)
    if (where(model.position[i])) sum += b[i] - a[i], count += 1;
  EXPECT_GT(count, 0) << its.name;
  return sum / count;
}

} // namespace pliant::test
