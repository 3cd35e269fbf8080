// Where the places of a fluid count from: floats have most digits near there.
#include "tests/support/viscoelastic.h"

#include <gtest/gtest.h>

namespace pliant::test {
namespace {

constexpr double spacing = 0.02;

Stage moved_stage(const Vector3& by) {
  Points points = lattice(5, 9, 3, spacing);
  for (Vector3& p : points) p += by;
  return fluid_stage(points, spacing, 1. / 600);
}

// Anywhere else each distance between neighbours loses as many digits as they are spacings away: from a
// corner of a coarse grid, 16 times the rounding (measured: of velocities after a step of clay).
TEST(FluidPlaces, CountFromTheMiddleOfTheFluid) {
  const Vector3 middle = spacing * Vector3(2, 4, 1);
  for (const Vector3& by : {Vector3(0, 0, 0), Vector3(7.3, -40.11, 2), Vector3(-1.01, 0.99, -0.3)}) {
    const Stage stage = moved_stage(by);
    const Vector3 base = fluid_model(stage.scene, stage.model).lattice.base;
    EXPECT_LT((base - middle - by).cwiseAbs().maxCoeff(), spacing) << by.transpose();
  }
}

TEST(FluidPlaces, MoveWithTheScene) {
  const Stage here = moved_stage(Vector3::Zero());
  const Vector3 base = fluid_model(here.scene, here.model).lattice.base;
  for (const Vector3& by : {Vector3(8, -0.5, 64), Vector3(-0.25, 1, -2)}) {
    const Stage there = moved_stage(by);
    EXPECT_EQ(fluid_model(there.scene, there.model).lattice.base, base + by);
  }
}

// Only matter with bonds, which a step may turn back, is listed beyond the reach.
TEST(FluidPlaces, AreListedALittleBeyondTheReachWhereTheyAreBonded) {
  const Points points = lattice(5, 5, 5, spacing);
  const Stage water = fluid_stage(points, spacing, 1. / 600);
  const FluidModel plain = fluid_model(water.scene, water.model);
  EXPECT_EQ(plain.list_reach, plain.reach);
  Stage unused = water; // a material that nothing is made of
  unused.scene.materials.push_back(viscoelastic(1e5, 0.3));
  EXPECT_EQ(fluid_model(unused.scene, unused.model).list_reach, plain.list_reach);
  const Stage clay = bonded_stage(points, spacing, 1. / 600, viscoelastic(1e5, 0.3));
  const FluidModel bonded = fluid_model(clay.scene, clay.model);
  EXPECT_NEAR(bonded.list_reach, 1.1 * bonded.reach, 1e-12);
  EXPECT_GE(bonded.lattice.edge.minCoeff(), bonded.list_reach);
  EXPECT_GT(bonded.rows, plain.rows);
}

// Images lie within a period and a half of a cell's middle, which counts from where the domain begins.
TEST(FluidPlaces, BeginWhereADomainRepeats) {
  Stage stage = moved_stage(Vector3(0.3, 0.3, 0.3));
  repeat(stage.scene, {0.25, -5, 0.25}, {0.55, 5, 0.5}, {true, false, true});
  const Vector3 base = fluid_model(stage.scene, stage.model).lattice.base;
  EXPECT_EQ(base.x(), 0.25);
  EXPECT_NEAR(base.y(), 0.38, spacing);
  EXPECT_EQ(base.z(), 0.25);
}

} // namespace
} // namespace pliant::test
