// Newton's method with either preconditioner: the solution, the potential, iteration counts, small budgets,
// contacts found anew during a solve, threads.
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;

struct Way {
  const char* method;
  const char* preconditioner;
  std::string name() const { return std::string(method) + " " + preconditioner; }
};
const Way newton_ways[] = {{"newton", "diagonal"}, {"newton", "multilevel"}};

void choose(Scene& scene, const Way& way, double tolerance, unsigned iterations) {
  scene.solver.method = way.method;
  scene.solver.preconditioner = way.preconditioner;
  scene.solver.tolerance = tolerance;
  scene.solver.iterations = iterations;
}

/// A bar, held at one end, twisted, that swings under gravity.
Stage cantilever(double young, double poisson, const char* law = "corotated", double twist = 0.3) {
  Stage stage(lattice(9, 3, 3, spacing), spacing, material_of(law, young, poisson), 1. / 60);
  stage.scene.simulation.gravity = {0, -9.81, 0};
  const Vector3 first = stage.model.position[0];
  stage.hold([&](const Vector3& x) { return x.x() < first.x() + 0.5 * spacing; });
  stage.move([&](const Vector3& x) -> Vector3 {
    const Vector3 axis = first + Vector3(0, spacing, spacing);
    return axis + Eigen::AngleAxisd(twist * (x.x() - first.x()), Vector3::UnitX()) * (x - axis);
  });
  return stage;
}

/// One body falls on another and on the floor.
struct Drop {
  Scene scene;
  Model model;
  explicit Drop(double friction, double young = 1e6) {
    scene.simulation.spacing = spacing;
    scene.simulation.time_step = 1. / 60;
    scene.output.fps = 60;
    scene.contact.friction = friction;
    scene.materials = {material_of("corotated", young, 0.3)};
    for (int k = 0; k < 2; ++k) {
      Body body;
      body.name = k ? "upper" : "lower";
      body.material = scene.materials[0].name;
      body.shape.kind = Shape::Kind::box;
      body.shape.size = Vector3(0.4, 0.3, 0.3);
      body.shape.at = Vector3(0.13 * k, 0.2 + 0.31 * k, 0.02 * k);
      body.shape.rotate_axis = Vector3::UnitZ();
      body.velocity = Vector3(0, k ? -3 : -1, 0);
      scene.bodies.push_back(body);
    }
    Boundary floor;
    floor.shape.kind = Shape::Kind::plane;
    floor.friction = friction;
    scene.boundaries = {floor};
    model = assemble(scene);
  }
};

struct Ran {
  Points positions;
  std::vector<StepStatistics> rows;
};
Ran run(Device& device, const Scene& scene, const Model& model, int steps) {
  Simulation simulation(device, scene, model);
  for (int k = 0; k < steps; ++k) simulation.step();
  return {simulation.positions(), simulation.take_statistics()};
}

bool all_finite(const Points& points) {
  for (const Vector3& x : points)
    if (!x.allFinite()) return false;
  return true;
}

class Solvers : public OnEachDevice {};

TEST_P(Solvers, FindTheSameSolution) {
  const auto reference_device = open_double(), open = device();
  for (const char* law : {"corotated", "ordinary"}) {
    if (GetParam().gl() && law == std::string("ordinary")) continue; // slow in software
    Stage stage = cantilever(1e6, 0.3, law);
    const int steps = GetParam().gl() ? 1 : 3;
    choose(stage.scene, {"chebyshev", "auto"}, 1e-12, 20000);
    const Ran wanted = run(*reference_device, stage.scene, stage.model, steps);
    for (const StepStatistics& row : wanted.rows) EXPECT_NE(row.reason, StopReason::cap);
    for (const Way& way : newton_ways) {
      // Float ends at its own floor, which a solution differs by from the exact one by the condition number.
      choose(stage.scene, way, is_double() ? 1e-12 : 1e-6, 3000);
      const Ran ran = run(*open, stage.scene, stage.model, steps);
      for (const StepStatistics& row : ran.rows) EXPECT_NE(row.reason, StopReason::cap) << way.name();
      expect_below(std::string(law) + ", " + way.name() + ": difference, spacings",
                   largest_difference(ran.positions, wanted.positions) / spacing, limit(1e-9, 2e-4));
    }
  }
}

TEST_P(Solvers, ContactsFoundAnewDoNoHarm) {
  const auto reference_device = open_double(), open = device();
  Drop drop(0);
  choose(drop.scene, {"chebyshev", "auto"}, 1e-11, 20000);
  const Ran wanted = run(*reference_device, drop.scene, drop.model, GetParam().gl() ? 2 : 4);
  for (const Way& way : newton_ways) {
    choose(drop.scene, way, is_double() ? 1e-11 : 1e-5, 3000);
    const Ran ran = run(*open, drop.scene, drop.model, GetParam().gl() ? 2 : 4);
    double longest = 0;
    for (const StepStatistics& row : ran.rows) {
      EXPECT_NE(row.reason, StopReason::cap) << way.name() << ", step " << row.step;
      longest = std::max(longest, double(row.iterations));
    }
    report(way.name() + ": most iterations of a step", longest);
    expect_above("iterations, of which some follow a new search", longest, 25);
    expect_below("drop, " + way.name() + ": difference, spacings",
                 largest_difference(ran.positions, wanted.positions) / spacing, limit(1e-8, 2e-3));
  }
  // With friction nothing has a potential: the line search goes by the work that forces did.
  if (GetParam().gl()) return;
  Drop rough(0.4);
  for (const Way& way : newton_ways) {
    choose(rough.scene, way, 1e-4, 2000);
    const Ran ran = run(*open, rough.scene, rough.model, 4);
    EXPECT_TRUE(all_finite(ran.positions));
    double worst = 0;
    for (const StepStatistics& row : ran.rows) worst = std::max(worst, row.residual);
    expect_below("drop with friction, " + way.name() + ": worst residual, relative", worst, 1e-4);
  }
}

/// Phi at the start and the end of a solve, on the same device; of the step after `warm` steps.
std::pair<double, double> potentials(Device& device, const Scene& scene, const Model& model, unsigned warm) {
  Simulation simulation(device, scene, model);
  for (unsigned k = 0; k < warm; ++k) simulation.step();
  const Snapshot before = simulation.snapshot();
  simulation.begin_solving();
  const Points start = simulation.iterate_positions();
  while (!simulation.iterate()) {
  }
  const Points end = simulation.iterate_positions();
  EXPECT_TRUE(all_finite(end));
  return {simulation.potential(start), simulation.potential(end)};
}

TEST_P(Solvers, ThePotentialNeverRises) {
  const auto open = device();
  Stage stage = cantilever(1e6, 0.45, "corotated", 2);
  stage.move([](const Vector3& x) -> Vector3 { return {x.x(), 0.6 * x.y(), 1.2 * x.z()}; });
  Drop drop(0);
  for (const Way& way : newton_ways)
    for (const unsigned budget : {1u, 2u, 3u, 7u, 26u, 100u}) {
      if (GetParam().gl() && (budget > 7 || budget == 2)) continue; // slow in software
      choose(stage.scene, way, 1e-6, budget);
      const auto [start, end] = potentials(*open, stage.scene, stage.model, 0);
      const std::string name = way.name() + ", " + std::to_string(budget) + " iterations";
      // What the line search can tell, of the potential.
      expect_below("twisted, " + name + ": rise of Phi, relative", (end - start) / start, limit(1e-13, 6e-6));
      if (budget > 3) {
        EXPECT_LT(end, 0.999 * start) << "twisted, " << name;
      }
      choose(drop.scene, way, 1e-6, budget);
      const auto [high, low] = potentials(*open, drop.scene, drop.model, 1);
      expect_below("drop, " + name + ": rise of Phi, relative", (low - high) / high, limit(1e-13, 6e-6));
    }
}

INSTANTIATE_TEST_SUITE_P(Physics, Solvers, testing::ValuesIn(device_choices()), ChoiceName());

TEST(Newton, IterationsHardlyDependOnStiffness) {
  const auto device = open_double();
  for (const double poisson : {0.25, 0.45}) {
    double least = 1e9, most = 0, plain = 0;
    for (const double young : {1e5, 1e6, 1e7, 1e8, 1e9}) {
      Stage stage = cantilever(young, poisson, "corotated", 0.05);
      choose(stage.scene, {"newton", "multilevel"}, 1e-6, 3000);
      const Ran ran = run(*device, stage.scene, stage.model, 2);
      double iterations = 0;
      for (const StepStatistics& row : ran.rows) {
        EXPECT_EQ(row.reason, StopReason::tolerance) << "E " << young << ", nu " << poisson;
        iterations = std::max(iterations, double(row.iterations));
      }
      report("nu " + std::to_string(poisson).substr(0, 4) + ", E " + std::to_string(int(young / 1e3)) +
                 " kPa: iterations",
             iterations);
      if (young > 2e5) least = std::min(least, iterations); // where a step is stiff at all
      most = std::max(most, iterations);
    }
    expect_below("most over least", most / least, 2.5);
    Stage stage = cantilever(1e9, poisson, "corotated", 0.05);
    choose(stage.scene, {"newton", "diagonal"}, 1e-6, 20000);
    for (const StepStatistics& row : run(*device, stage.scene, stage.model, 2).rows)
      plain = std::max(plain, double(row.iterations));
    report("diagonal at E 1000000 kPa", plain);
    expect_above("diagonal over multilevel", plain / most, 1.2); // 243 unknowns: few for either
  }
}

// Double sums of the same groups in the same order whatever the number of threads.
TEST(Newton, SameBitsForAnyNumberOfThreads) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    std::string first;
    for (const unsigned threads : {1u, 2u}) {
      const auto device = open_alone({"", "openmp", precision}, threads);
      Drop drop(0.3);
      choose(drop.scene, {"newton", "multilevel"}, 1e-4, 200);
      Simulation simulation(*device, drop.scene, drop.model);
      for (int k = 0; k < 3; ++k) simulation.step();
      if (threads == 1) first = simulation.hash();
      EXPECT_EQ(simulation.hash(), first) << threads << " threads";
    }
  }
}

} // namespace
} // namespace pliant::test
