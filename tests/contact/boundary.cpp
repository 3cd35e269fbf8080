// Obstacles: distances and normals, energy, friction, motion, precision.
#include "tests/contact/world.h"

#include <cmath>

namespace pliant::test {
namespace {

Shape shape_of(Shape::Kind kind) {
  Shape shape;
  shape.kind = kind;
  shape.at = {0.3, -0.2, 0.5};
  shape.size = {1.0, 0.6, 0.8};
  shape.radius = kind == Shape::Kind::torus ? 0.6 : 0.5;
  shape.tube = 0.2;
  shape.height = 0.7;
  shape.normal = Vector3(1, 2, -2) / 3;
  shape.offset = 0.15;
  shape.rotate_axis = Vector3(2, -1, 2) / 3;
  shape.rotate_degrees = kind == Shape::Kind::plane ? 0 : 35;
  return shape;
}

// What the kernel should find: force and stiffness k = 1000 at depth radius - d of ShapeQuery's exact
// distance.
double depth_at(const ShapeQuery& query, const Vector3& p, double radius, bool inside) {
  return radius - (inside ? -1 : 1) * query.signed_distance(p);
}

class Boundaries : public ContactTest {};

void check_shape(Device& device, double epsilon, Shape::Kind kind, bool inside) {
  const Shape shape = shape_of(kind);
  const ShapeQuery query(shape, ".");
  World world;
  world.add_boundary(shape, inside);
  world.add_body({0.25, 0.1, -0.4});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (int i = 0; i < 403; ++i) { // no multiple of a group
    const Vector3 u = 0.05 * Vector3(coordinate(random), coordinate(random), coordinate(random));
    world.add(shape.at + Vector3(coordinate(random), coordinate(random), coordinate(random)), u);
  }
  Bench bench(device, world);
  const auto forces = bench.forces();
  const auto touched = bench.touched();
  const double k = 1000, radius = world.model.spacing / 2, e = 1e-5;
  int hits = 0;
  for (std::size_t i = 0; i < world.count(); ++i) {
    const Vector3 p = world.model.position[i] + world.displacement[i];
    const double depth = depth_at(query, p, radius, inside);
    if (std::abs(depth) < 1e-5) continue;
    EXPECT_EQ(touched[i], depth > 0 ? 1u : 0u) << "particle " << i << " at depth " << depth;
    EXPECT_NEAR(forces[i].w, depth > 0 ? 2 * k : k, 1e-3);
    // - gradient of 1/2 k depth^2 by central differences.
    Vector3 expected = Vector3::Zero();
    for (int a = 0; a < 3 && depth > 0; ++a) {
      Vector3 step = Vector3::Zero();
      step[a] = e;
      const double more = std::max(depth_at(query, p + step, radius, inside), 0.0);
      const double less = std::max(depth_at(query, p - step, radius, inside), 0.0);
      expected[a] = -k * (more * more - less * less) / (4 * e);
    }
    // Near a ridge of the distance the difference mixes two sides.
    if (depth > 0 && std::abs(expected.norm() - k * depth) > 1e-4 * k * depth) continue;
    hits += depth > 0;
    // u acts through rounding of coordinates of size one: a few units of the last place, times k.
    const double slip = 30 * epsilon * k + 2e-6 * k * std::max(depth, 0.0);
    // The frictionless force plus nothing else.
    EXPECT_LT((vector_of(forces[i]) - expected).norm(), slip + 20 * epsilon * k) << "particle " << i;
  }
  EXPECT_GT(hits, 20);
}

TEST_P(Boundaries, ForceIsTheGradientOfThePenalty) {
  using Kind = Shape::Kind;
  for (const Kind kind : {Kind::plane, Kind::sphere, Kind::box, Kind::cylinder, Kind::torus})
    for (const bool inside : {false, true}) {
      if (inside && kind == Kind::plane) continue;
      SCOPED_TRACE("kind " + std::to_string(int(kind)) + (inside ? " inside" : " outside"));
      check_shape(*device, epsilon, kind, inside);
    }
}

Shape floor_shape() {
  Shape shape;
  shape.kind = Shape::Kind::plane;
  return shape;
}

TEST_P(Boundaries, FrictionSticksBelowTheConeAndSlidesOnIt) {
  World world;
  world.add_boundary(floor_shape(), false, 0.5);
  const double depth = 0.01, limit = 0.5 * depth; // slides where u_t > mu depth
  for (const double slide : {0.0, 0.3 * limit, 0.99 * limit, 1.01 * limit, 7 * limit})
    world.add({0, 0.05 - depth, 0}, {0.6 * slide, 0, 0.8 * slide});
  Bench bench(*device, world);
  const auto forces = bench.forces();
  for (std::size_t i = 0; i < world.count(); ++i) {
    const double slide = world.displacement[i].norm(), friction = 1000 * std::min(slide, limit);
    EXPECT_NEAR(forces[i].x, -0.6 * friction, 200 * epsilon);
    EXPECT_NEAR(forces[i].z, -0.8 * friction, 200 * epsilon);
    EXPECT_NEAR(forces[i].y, 1000 * depth, 200 * epsilon);
  }
}

TEST_P(Boundaries, NoSlipHoldsAndDragsWithATurningObstacle) {
  World world;
  world.add_boundary(floor_shape());
  Boundary& plate = world.scene.boundaries[0];
  plate.slip = false;
  plate.motion.velocity = {2, 0, 0};
  plate.motion.rate = 3;
  plate.motion.about = {0, 0, -0.6};
  world.add({0.4, 0.04, 0.2}, {0.01, 0, -0.02});
  Bench bench(*device, world);
  const auto forces = bench.forces();
  // The plate's point that is at p at the end of the step was at before(after^-1(p)).
  const RigidMap after = motion_at(plate.motion, world.step);
  const Vector3 p = world.model.position[0] + world.displacement[0];
  const Vector3 from = after.rotation.transpose() * (p - after.shift);
  const Vector3 expected = -1000 * (world.displacement[0] - (p - from)) + Vector3(0, 1000 * 0.01, 0);
  EXPECT_LT((vector_of(forces[0]) - expected).norm(), 2000 * epsilon);
  EXPECT_GT(forces[0].x, 30); // dragged along +x: 4.4 m/s against 1 m/s
}

TEST_P(Boundaries, MovingObstacleIsWhereItsMotionTakesItAndStops) {
  World world;
  world.add_boundary(floor_shape());
  Motion& motion = world.scene.boundaries[0].motion;
  motion.velocity = {0, 1, 0};
  motion.start = 1;
  motion.end = 3;
  world.add({0, 0.5, 0});
  Bench bench(*device, world);
  const auto at = [&](double time) {
    bench.contacts.begin_step(time - world.step, world.step, bench.state);
    return bench.forces()[0].y;
  };
  EXPECT_EQ(at(1), 0); // floor at 0, the particle's surface at 0.45
  EXPECT_NEAR(at(1.6), 1000 * 0.15, 2000 * epsilon);
  EXPECT_NEAR(at(5), 1000 * 1.55, 5000 * epsilon); // stands at 2
}

// A gate that stands still, and a floor that has risen: both are gone after their end, for points anywhere,
// and no earlier.
TEST_P(Boundaries, ReleasedObstacleIsGoneAfterItsEnd) {
  for (const Shape::Kind kind : {Shape::Kind::plane, Shape::Kind::sphere, Shape::Kind::box})
    for (const double speed : {0.0, 0.01}) {
      SCOPED_TRACE("kind " + std::to_string(int(kind)) + ", speed " + std::to_string(speed));
      World world;
      Shape shape = shape_of(kind);
      shape.at = {0, 0, 0};
      shape.normal = {0, 1, 0};
      shape.offset = 0.02;
      world.add_boundary(shape, false, 0.5);
      world.add_boundary(floor_shape()); // stays, far below
      world.scene.boundaries[1].shape.offset = -0.04;
      Motion& motion = world.scene.boundaries[0].motion;
      motion.velocity = {0, speed, 0};
      motion.end = 2;
      motion.release = true;
      world.add({0, 0, 0}); // the very centre of the sphere and of the box
      world.add({0.01, 0.02, -0.03}, {0.001, 0, 0});
      world.add({0, -0.05, 0}); // 0.06 below the other floor's reach
      Bench bench(*device, world);
      const auto at = [&](double time) {
        bench.contacts.begin_step(time - world.step, world.step, bench.state);
        return bench.forces();
      };
      EXPECT_GT(vector_of(at(1.5)[1]).norm(), 1);
      EXPECT_GT(vector_of(at(2.0)[1]).norm(), 1); // acts to its end
      const auto after = at(2.0 + world.step);
      EXPECT_EQ(bench.touched(), (std::vector<std::uint32_t>{1, 0, 1}));
      EXPECT_NEAR(after[0].y, 1000 * 0.01, 200 * epsilon); // the floor that stays
      EXPECT_EQ(vector_of(after[1]).norm(), 0);
      EXPECT_NEAR(after[2].y, 1000 * 0.06, 200 * epsilon);
    }
}

// Far displacement and small change: a step of 1e-7 m at y = 0.8 m changes the force by k 1e-7, not by a
// rounding.
TEST_P(Boundaries, SmallDisplacementsKeepTheirDigits) {
  for (const Shape::Kind kind :
       {Shape::Kind::plane, Shape::Kind::sphere, Shape::Kind::box, Shape::Kind::cylinder}) {
    World world;
    Shape shape = shape_of(kind);
    shape.at = {0, 0, 0};
    shape.rotate_degrees = 0;
    shape.normal = {0, 1, 0};
    shape.offset = 0.8;
    shape.radius = 0.8;
    shape.size = {1.6, 1.6, 1.6};
    shape.height = 1.6;
    world.add_boundary(shape);
    const Vector3 at(0.0, 0.82, 0.0);
    world.add(at, {0, 0, 0});
    world.add(at, {0, 1e-7, 0});
    Bench bench(*device, world);
    const auto forces = bench.forces();
    EXPECT_NEAR(forces[0].y - forces[1].y, 1000 * 1e-7, 1000 * 1e-7 * 0.03 + 32 * 4 * epsilon) << int(kind);
  }
}

TEST_P(Boundaries, StoppedSolverAndLooseParticles) {
  World world;
  world.add_boundary(floor_shape());
  world.add({0, 0, 0}, Vector3::Zero(), 0);
  Bench bench(*device, world);
  const double least = 1 / (world.step * world.step);
  EXPECT_NEAR(bench.forces()[0].y, least * 0.05, 1e4 * epsilon);
  std::vector<double> stop(SOLVER_ENTRIES, 0);
  stop[SOLVER_STOP] = 1;
  device->upload(bench.state.solver, stop);
  EXPECT_EQ(bench.forces()[0].y, 0);
}

INSTANTIATE_TEST_SUITE_P(Devices, Boundaries, testing::ValuesIn(device_choices()),
                         [](const auto& one) { return ChoiceName()(one); });

TEST(ContactPlan, NothingWhereNothingCanTouch) {
  World world;
  world.scene.contact.bodies = true;
  world.add({0, 0, 0});
  const auto device = device_choices()[0].open();
  const std::size_t before = device->bytes_allocated();
  Contacts contacts(*device, world.scene, world.model, Vector3::Zero());
  contacts.prepare();
  EXPECT_TRUE(contacts.plan().buffers.empty());
  EXPECT_TRUE(contacts.plan().kernels.empty());
  EXPECT_EQ(device->bytes_allocated(), before);
  EXPECT_TRUE(device->kernels_prepared().empty());
  EXPECT_EQ(contacts.touched(), nullptr);
}

TEST(ContactPlan, FloorAloneNeedsOneKernelAndNoGrid) {
  World world;
  world.add({0, 0, 0});
  world.add_boundary(floor_shape());
  const ContactPlan plan = plan_contacts(world.scene, world.model);
  ASSERT_EQ(plan.kernels.size(), 1u);
  EXPECT_STREQ(plan.kernels[0].info->name, "boundary_contact");
  ASSERT_EQ(plan.buffers.size(), 2u);
  EXPECT_EQ(plan.buffers[0].name, "touched");
  EXPECT_EQ(plan.buffers[1].name, "obstacle");
}

TEST(ContactPlan, TooManyBoundaries) {
  World world;
  world.add({0, 0, 0});
  for (int i = 0; i < 33; ++i) world.add_boundary(floor_shape());
  EXPECT_THROW(plan_contacts(world.scene, world.model), Error);
}

} // namespace
} // namespace pliant::test
