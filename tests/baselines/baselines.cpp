// The methods of bench/baselines do what their sources say: what Pliant is compared with must be right too.
#include "bench/baselines/explicit.h"
#include "bench/baselines/trial.h"
#include "engine/core/error.h"
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

using bench::make_baseline;

constexpr double spacing = 0.1, young = 1e5;

Vector3 momentum(const Model& model, const bench::Baseline& baseline) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < model.count(); ++i) sum += model.mass[i] * baseline.velocities()[i];
  return sum;
}

/// Of a method that takes explicit steps.
std::unique_ptr<bench::ExplicitIntegration> make_explicit_one(const std::string& method, const Stage& stage) {
  auto made = make_baseline(method, stage.scene, stage.model);
  auto* as_explicit = dynamic_cast<bench::ExplicitIntegration*>(made.get());
  if (!as_explicit) throw Error(ExitCode::internal, method + " takes no explicit steps");
  made.release();
  return std::unique_ptr<bench::ExplicitIntegration>(as_explicit);
}

// Two masses m on a spring k = 12 E V / L^2 swing at w^2 = 2 k / m; implicit Euler's steps of w h = 0.02 turn
// the phase by atan(w h), 1.3e-4 less. Crossings are interpolated linearly, to 1e-5 of a period.
TEST(MassSpring, SwingsAtItsFrequency) {
  Stage stage({Vector3::Zero(), Vector3(spacing, 0, 0)}, spacing, material_of("corotated", young, 0.25), 1);
  const double k = 12 * young * stage.model.volume[0] / (spacing * spacing);
  const double w = std::sqrt(2 * k / stage.model.mass[0]), h = 0.02 / w;
  stage.model.position[1].x() += 0.01 * spacing;
  const auto pair = make_baseline("mass-spring", stage.scene, stage.model);
  std::vector<double> crossings;
  double before = 0.01 * spacing;
  while (crossings.size() < 5 && pair->time() < 20 / w) {
    pair->advance(h);
    const double now = pair->positions()[1].x() - pair->positions()[0].x() - spacing;
    if (now * before < 0) crossings.push_back(pair->time() - h * now / (now - before));
    before = now;
  }
  ASSERT_EQ(crossings.size(), 5u);
  const double frequency = 4 * M_PI / (crossings[4] - crossings[0]);
  expect_below("error of the frequency", std::abs(frequency / w * 0.02 / std::atan(0.02) - 1), 1e-4);
}

// Springs matched to an isotropic neighbourhood return the Young's modulus typed: a bar of 3 x 3 particles
// drawn by a load, at rest. 2.1 % is what fourth moments leave at three layers.
TEST(MassSpring, ReturnsTheModulusTyped) {
  Stage stage(lattice(16, 3, 3, spacing), spacing, material_of("corotated", young, 0.25), 1);
  const double left = stage.model.position.front().x(), pull = 1e-3 * young * 9 * spacing * spacing;
  const Points rest = stage.model.position;
  stage.hold([&](const Vector3& x) { return x.x() < left + spacing / 2; });
  stage.load([&](const Vector3& x) { return x.x() > left + 14.5 * spacing; }, {pull, 0, 0});
  const auto bar = make_baseline("mass-spring", stage.scene, stage.model);
  for (int k = 0; k < 30; ++k) bar->advance(1);
  double strain = 0; // between layers 5 and 10, away from the ends
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const double layer = (rest[i].x() - left) / spacing, moved = bar->positions()[i].x() - rest[i].x();
    if (std::abs(layer - 5) < 0.5) strain -= moved / 9;
    if (std::abs(layer - 10) < 0.5) strain += moved / 9;
  }
  expect_below("error of Young's modulus", std::abs(1e-3 / (strain / (5 * spacing)) - 1), 0.04);
}

// Goals have their cluster's centre and sum of m y* x (goal - y*) = 0, however many clusters overlap.
TEST(ShapeMatching, ConservesMomentumAndComesToRest) {
  Stage stage(lattice(5, 4, 3, spacing), spacing, material_of("corotated", young, 0.25), 1);
  std::mt19937 random(3);
  for (std::size_t i = 0; i < stage.model.count(); ++i) {
    stage.model.position[i] += 0.2 * spacing * random_vector(random);
    stage.model.velocity[i] = Vector3(1, 2, 3) + random_vector(random);
  }
  const auto body = make_baseline("shape-matching", stage.scene, stage.model);
  const Vector3 before = momentum(stage.model, *body);
  double turned = 0; // what matching adds to the angular momentum of the step's inertial motion
  constexpr double h = 0.01;
  for (int k = 0; k < 300; ++k) {
    const Points target = plus(body->positions(), h, body->velocities());
    body->advance(h);
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 0; i < target.size(); ++i)
      sum += stage.model.mass[i] * target[i].cross(body->positions()[i] - target[i]) / h;
    turned = std::max(turned, sum.norm());
  }
  // 300 roundings of positions of 10 m, over h.
  expect_below("momentum lost", (momentum(stage.model, *body) - before).norm() / before.norm(), 1e-11);
  expect_below("largest torque of a step, of its momentum times 10 spacings",
               turned / (before.norm() * 10 * spacing), 1e-9);
  expect_below("rms distance to the rest shape, spacings", bench::measure(stage.model, *body).distance, 1e-3);
}

// Symplectic Euler's energy swings about a constant by O(w h), without a trend.
TEST(Explicit, ConservesEnergyAtSmallSteps) {
  Stage stage(lattice(5, 4, 3, spacing), spacing, material_of("corotated", young, 0.3), 1);
  stage.move([](const Vector3& x) { return Vector3(1.02 * x.x() + 0.01 * x.y(), x.y(), 0.99 * x.z()); });
  const auto open = open_double();
  Simulation energy(*open, stage.scene, stage.model);
  const auto body = make_explicit_one("explicit", stage);
  const double h = body->stable_step() / 50;
  const auto total = [&] {
    double sum = energy.elastic_energy(body->positions());
    for (std::size_t i = 0; i < stage.model.count(); ++i)
      sum += stage.model.mass[i] / 2 * body->velocities()[i].squaredNorm();
    return sum;
  };
  const double first = total();
  double worst = 0, early = 0, late = 0;
  for (int k = 0; k < 2000; ++k) {
    body->advance(h);
    if (k % 10 != 0) continue;
    const double now = total() / first;
    worst = std::max(worst, std::abs(now - 1));
    (k < 1000 ? early : late) += now / 100;
  }
  expect_below("largest departure of energy", worst, 0.02);
  expect_below("trend between the halves of the run", std::abs(late - early), 1e-3);
  expect_below("momentum gained, of m v", momentum(stage.model, *body).norm() / std::sqrt(first), 1e-10);
}

// The step found is the limit: a little below it a small disturbance stays small, a little above it grows.
// The stiffness number's bound, h^2 max K / m < 2, lies below it.
TEST(Explicit, KnowsItsStableStep) {
  Stage stage(lattice(4, 4, 4, spacing), spacing, material_of("corotated", young, 0.3), 1);
  std::mt19937 random(7);
  for (Vector3& v : stage.model.velocity) v = 1e-5 * random_vector(random);
  const std::vector<double> k = diagonal_stiffness(stage.model);
  double bound = 1e300;
  for (std::size_t i = 0; i < k.size(); ++i)
    bound = std::min(bound, std::sqrt(2 * stage.model.mass[i] / k[i]));
  for (const char* method : {"explicit", "mls"}) {
    double speed[2];
    double limit = 0;
    for (const int above : {0, 1}) {
      const auto body = make_explicit_one(method, stage);
      limit = body->stable_step();
      for (int n = 0; n < 400; ++n) body->advance((above ? 1.04 : 0.96) * limit);
      speed[above] = bench::measure(stage.model, *body).speed;
    }
    const std::string name = method;
    expect_below(name + ": speed after 400 steps 4 % below the limit, m/s", speed[0], 1e-4);
    expect_above(name + ": and 4 % above it", speed[1], 1e-3);
    if (name == "explicit") expect_above("limit over the bound of the stiffness number", limit / bound, 1);
  }
}

TEST(MovingLeastSquares, FeelsNoRigidMotionAndTheStressOfAStretch) {
  const double poisson = 0.3;
  Stage stage(lattice(9, 9, 9, spacing), spacing, material_of("corotated", young, poisson), 1);
  const auto body = make_explicit_one("mls", stage);
  const Matrix3 turn = Eigen::AngleAxisd(2.1, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  Points y;
  for (const Vector3& x : stage.model.reference) y.push_back(turn * x + Vector3(3, -1, 2));
  const double scale = young * spacing * spacing;
  expect_below("force under a rigid motion, of E d^2", largest(body->forces(y)) / scale, 1e-11);
  // Stretched by e along x and turned: inside, none; across the middle section, (lambda + 2 mu) e times its
  // area.
  const double e = 1e-3, mu = young / (2 * (1 + poisson)), lambda = 2 * mu * poisson / (1 - 2 * poisson);
  const double middle = stage.model.reference.front().x() + 4 * spacing;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const Vector3& x = stage.model.reference[i];
    y[i] = turn * Vector3((1 + e) * x.x(), x.y(), x.z());
  }
  const Points force = body->forces(y);
  Vector3 half = Vector3::Zero(), sum = half;
  double inside = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const Vector3 at = (stage.model.reference[i] - stage.model.reference.front()) / spacing;
    if ((at.array() > 3.5).all() && (at.array() < 4.5).all()) inside = std::max(inside, force[i].norm());
    if (stage.model.reference[i].x() > middle - spacing / 2) half += turn.transpose() * force[i];
    sum += force[i];
  }
  expect_below("sum of forces, of E d^2", sum.norm() / scale, 1e-11);
  expect_below("force in the middle, of E d^2", inside / scale, 1e-11);
  const double area = 81 * spacing * spacing;
  expect_below("error of the stress", std::abs(-half.x() / (area * (lambda + 2 * mu) * e) - 1), 1e-9);
}

// All of them fall alike, hold what is held, and stand on a floor.
TEST(Baselines, FallHoldAndLand) {
  for (const char* method : bench::method_names()) {
    Stage stage(lattice(3, 3, 3, spacing), spacing, material_of("corotated", young, 0.25), 1);
    stage.scene.simulation.gravity = {0, -10, 0};
    const auto falling = make_baseline(method, stage.scene, stage.model);
    for (int k = 0; k < 100; ++k) falling->advance(1e-3);
    expect_below(std::string(method) + ": error of the speed of a fall of 0.1 s, m/s",
                 (momentum(stage.model, *falling) / (27 * stage.model.mass[0]) - Vector3(0, -1, 0)).norm(),
                 1e-6);

    Boundary floor;
    floor.shape.kind = Shape::Kind::plane;
    floor.shape.offset = stage.model.position.front().y() - 0.5 * spacing;
    stage.scene.boundaries = {floor};
    stage.hold([](const Vector3& x) { return x.x() < 0.5 * spacing; });
    const Points rest = stage.model.position;
    const auto standing = make_baseline(method, stage.scene, stage.model);
    standing->set_damping(50);
    for (int k = 0; k < 300; ++k) standing->advance(1e-3);
    double held = 0, lowest = 1e300;
    for (const Held& h : stage.model.held)
      held = std::max(held, (standing->positions()[h.particle] - rest[h.particle]).norm());
    for (const Vector3& p : standing->positions()) lowest = std::min(lowest, p.y());
    expect_below(std::string(method) + ": held particles moved, m", held, 1e-12);
    expect_above(std::string(method) + ": lowest particle over the floor, m", lowest - floor.shape.offset,
                 -0.02 * spacing);
  }
}

TEST(Baselines, RefuseWhatTheyDoNotKnow) {
  Stage stage(lattice(3, 3, 3, spacing), spacing, material_of("corotated", young, 0.25), 1);
  EXPECT_THROW(make_baseline("finite-elements", stage.scene, stage.model), Error);
  Boundary ball;
  ball.name = "ball";
  ball.shape.kind = Shape::Kind::sphere;
  stage.scene.boundaries = {ball};
  EXPECT_THROW(make_baseline("mls", stage.scene, stage.model), Error);
}

} // namespace
} // namespace pliant::test
