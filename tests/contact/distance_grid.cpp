// Distance grids against exact distances, and particles against a mesh.
#include "tests/contact/world.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <unistd.h>

namespace pliant::test {
namespace {

Shape ball() {
  Shape shape;
  shape.kind = Shape::Kind::sphere;
  shape.at = {0.1, 0.2, -0.1};
  shape.radius = 0.5;
  return shape;
}

TEST(DistanceGrid, InterpolatesASphereToSecondOrder) {
  const ShapeQuery query(ball(), ".");
  double worst[2] = {0, 0};
  for (int level = 0; level < 2; ++level) {
    const DistanceGrid grid = make_distance_grid(query, level ? 0.05 : 0.1);
    ASSERT_EQ(grid.distance.size(), grid.count());
    std::mt19937 random(4);
    std::uniform_real_distribution<double> u(-0.6, 0.6);
    for (int i = 0; i < 2000; ++i) {
      const Vector3 p = ball().at + Vector3(u(random), u(random), u(random));
      const double exact = query.signed_distance(p);
      if (std::abs(exact) < 0.1) worst[level] = std::max(worst[level], std::abs(grid.at(p) - exact));
    }
  }
  // Trilinear: at most cell^2 / 8 times the sum of curvatures, 2 / r with r >= 0.4.
  EXPECT_LT(worst[0], 0.1 * 0.1 / 8 * 2 / 0.4);
  EXPECT_LT(worst[1], worst[0] / 2.5);
}

TEST(DistanceGrid, ReachesBeyondTheSurfaceAndKeepsSigns) {
  const ShapeQuery query(ball(), ".");
  const DistanceGrid grid = make_distance_grid(query, 0.03);
  for (std::uint32_t z = 0; z < grid.nodes[2]; ++z)
    for (std::uint32_t y = 0; y < grid.nodes[1]; ++y)
      for (std::uint32_t x = 0; x < grid.nodes[0]; ++x) {
        const double d = grid.distance[(std::size_t{z} * grid.nodes[1] + y) * grid.nodes[0] + x];
        const double exact = query.signed_distance(grid.node(x, y, z));
        ASSERT_EQ(d > 0, exact > 0);
        if (std::abs(exact) < 3 * 0.03) {
          ASSERT_NEAR(d, exact, 1e-12);
        }
      }
  for (int a = 0; a < 3; ++a) {
    EXPECT_LE(grid.low[a], ball().at[a] - 0.5 - 2.9 * 0.03);
    EXPECT_GE(grid.low[a] + 0.03 * (grid.nodes[a] - 1), ball().at[a] + 0.5 + 2.9 * 0.03);
  }
}

class MeshBoundary : public ContactTest {};

// A cube as a mesh: flat faces, so that the grid is exact away from its edges.
TEST_P(MeshBoundary, ForceIsTheGradientOfTheGridsDistance) {
  const std::string file = testing::TempDir() + "pliant_contact_cube_" + std::to_string(getpid()) + ".off";
  std::ofstream(file) << "OFF\n8 12 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
                         "3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n"
                         "3 2 3 7\n3 2 7 6\n3 1 2 6\n3 1 6 5\n3 0 4 7\n3 0 7 3\n";
  Shape shape;
  shape.kind = Shape::Kind::mesh;
  shape.mesh = file;
  shape.place = Vector3(0.1, 0.2, -0.1);
  shape.at = *shape.place;
  for (const bool inside : {false, true}) {
    World world;
    world.add_boundary(shape, inside);
    Motion& motion = world.scene.boundaries[0].motion;
    motion.velocity = {20, 0, 0}; // turned and moved by the end of the step
    motion.rate = 30;
    motion.about = shape.at;
    const RigidMap placed = motion_at(motion, world.step);
    std::mt19937 random(8);
    std::uniform_real_distribution<double> c(-0.6, 0.6), small(-0.05, 0.05);
    for (int i = 0; i < 300; ++i)
      world.add(placed(shape.at + Vector3(c(random), c(random), c(random))),
                {small(random), small(random), small(random)});
    world.add({30, 0, 0}); // far outside the grid
    Bench bench(*device, world);
    const auto forces = bench.forces();
    const DistanceGrid grid = make_distance_grid(ShapeQuery(shape, "."), world.scene.simulation.spacing);
    int hits = 0;
    for (std::size_t i = 0; i + 1 < world.count(); ++i) {
      const Vector3 p = world.model.position[i] + world.displacement[i];
      const Vector3 own = placed.rotation.transpose() * (p - placed.shift),
                    in_cells = (own - grid.low) / grid.cell;
      const Vector3 off = in_cells - in_cells.array().round().matrix();
      if (off.cwiseAbs().minCoeff() < 1e-4) continue; // between cells the gradient jumps
      Vector3 gradient;
      const double sense = inside ? -1 : 1, depth = 0.05 - sense * grid.at(own, &gradient);
      const Vector3 expected =
          depth > 0 ? Vector3(1000 * depth * sense * (placed.rotation * gradient)) : Vector3::Zero();
      hits += depth > 0;
      EXPECT_LT((vector_of(forces[i]) - expected).norm(), 1e-11 + 2e4 * epsilon) << i;
    }
    EXPECT_GT(hits, 50);
    const Vector3 last = vector_of(forces.back());
    if (inside) {
      EXPECT_LT(last[0], -1e4); // a container brings back what left it
    } else {
      EXPECT_EQ(last.norm(), 0);
    }
  }
  std::remove(file.c_str());
}

INSTANTIATE_TEST_SUITE_P(Devices, MeshBoundary, testing::ValuesIn(device_choices()),
                         [](const auto& one) { return ChoiceName()(one); });

} // namespace
} // namespace pliant::test
