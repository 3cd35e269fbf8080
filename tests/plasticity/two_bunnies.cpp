// The example scene after He, Wang and Wu, "Projective Peridynamics for Modeling Versatile Elastoplastic
// Materials" (2018), Fig. 9, coarser: two bunnies that collide keep their dents.
#include "engine/core/error.h"
#include "engine/scene/mesh.h"
#include "engine/scene/mesh_file.h"
#include "engine/scene/scene_parse.h"
#include "tests/support/bodies.h"

#include <Eigen/Geometry>

namespace pliant::test {
namespace {

struct Collision {
  double deepest = 0, depth = 0;     ///< m: of the dents, at their most and in the end
  double apart = 0;                  ///< m/s, in the end
  double most_energy = 0, taken = 0; ///< of what there was; of it, by flow
};

/// How far the lower half of a body has gone in on the side that faces the other, seen from the side that
/// does not: the most, m. `toward`: 1 if it faces along x, -1 if against it. Ears swing, and count for
/// neither.
double dent(const Points& y, const Points& rest, const BodyModel& body, double toward) {
  Vector3 low = rest[body.first], high = low;
  for (std::size_t k = body.first; k < body.first + body.count; ++k)
    low = low.cwiseMin(rest[k]), high = high.cwiseMax(rest[k]);
  const Vector3 middle = (low + high) / 2;
  std::vector<std::size_t> near, far;
  for (std::size_t k = body.first; k < body.first + body.count; ++k)
    if (rest[k].y() < middle.y()) (toward * (rest[k].x() - middle.x()) > 0 ? near : far).push_back(k);
  const auto count = static_cast<Eigen::Index>(far.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from.col(i) = y[far[static_cast<std::size_t>(i)]];
    to.col(i) = rest[far[static_cast<std::size_t>(i)]];
  }
  const Eigen::Matrix4d back = Eigen::umeyama(from, to, false);
  double most = 0;
  for (const std::size_t k : near)
    most = std::max(most, toward * (rest[k].x() - (back.row(0) * y[k].homogeneous()).value()));
  return most;
}

Collision collide(Scene scene, bool flows) {
  scene.materials[0].plastic.given = flows;
  const Model model = assemble(scene);
  const auto open = open_alone({"openmp_float", "openmp", Precision::single_precision});
  Simulation simulation(*open, scene, model);
  double begun = 0;
  for (std::size_t i = 0; i < model.count(); ++i)
    begun += 0.5 * model.mass[i] * model.velocity[i].squaredNorm();
  Collision found;
  for (int frame = 0; frame < 12; ++frame) {
    for (int k = 0; k < 10; ++k) simulation.step();
    for (const StepStatistics& row : simulation.take_statistics()) {
      found.most_energy =
          std::max(found.most_energy, (row.kinetic_energy + row.elastic_energy + row.plastic_work) / begun);
      found.taken = row.plastic_work / begun;
    }
    const Points y = simulation.positions();
    found.depth =
        std::max(dent(y, model.position, model.bodies[0], 1), dent(y, model.position, model.bodies[1], -1));
    found.deepest = std::max(found.deepest, found.depth);
  }
  const std::vector<Vector3> v = simulation.velocities();
  for (std::size_t i = 0; i < v.size(); ++i) // two bodies of one number of particles
    found.apart += (model.body[i] == 1 ? 2 : -2) * v[i].x() / static_cast<double>(v.size());
  std::printf("  %s: %zu particles, dent %.1f mm at most, %.1f mm in the end; %.2f m/s apart, %.2f of the "
              "energy taken by flow\n",
              flows ? "clay" : "elastic", v.size(), 1e3 * found.deepest, 1e3 * found.depth, found.apart,
              found.taken);
  return found;
}

TEST(TwoBunnies, KeepTheirDents) {
  const Scene scene =
      read_scene(PLIANT_SOURCE_DIR "/examples/two-bunnies.toml",
                 std::vector<std::string>{"simulation.spacing=0.08", "solver.iterations=100"});
  try {
    find_mesh(scene.bodies[0].shape.mesh, scene.file.parent_path());
  } catch (const Error&) {
    GTEST_SKIP() << "bunny00.off is not on this machine";
  }
  const Collision clay = collide(scene, true), elastic = collide(scene, false);
  EXPECT_GT(clay.depth, scene.simulation.spacing);
  EXPECT_GT(clay.depth, 0.8 * clay.deepest);
  EXPECT_LT(elastic.depth, 0.05 * elastic.deepest);
  EXPECT_GT(clay.taken, 0.5);
  EXPECT_EQ(elastic.taken, 0);
  EXPECT_GT(clay.apart, 0);
  EXPECT_GT(elastic.apart, 2 * clay.apart);
  for (const Collision* one : {&clay, &elastic})
    expect_below("largest energy, of that at the start", one->most_energy, 1.001);
}

// The same of matter that exchanges its neighbours.
TEST(TwoBunnies, OfViscoelasticClayKeepTheirsToo) {
  const Scene scene =
      read_scene(PLIANT_SOURCE_DIR "/examples/two-clays.toml",
                 std::vector<std::string>{"simulation.spacing=0.08", "solver.iterations=100"});
  try {
    find_mesh(scene.bodies[0].shape.mesh, scene.file.parent_path());
  } catch (const Error&) {
    GTEST_SKIP() << "bunny00.off is not on this machine";
  }
  const Collision clay = collide(scene, true);
  EXPECT_GT(clay.depth, scene.simulation.spacing);
  EXPECT_GT(clay.depth, 0.9 * clay.deepest);
  expect_below("largest energy, of that at the start", clay.most_energy, 1.01);
}

} // namespace
} // namespace pliant::test
