// The relative energy error of Xu et al. (2018), Eq. 25: that solves which end by it are as close to the
// converged step as they say, that the potential never rises on the way, and that every method ends at the
// same place, for every law.
#include "engine/plan/method.h"
#include "tests/laws/materials.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;

std::vector<NamedMaterial> materials() {
  std::vector<NamedMaterial> all = some_materials(5e5, 0.25);
  all.push_back({"A1", basis_of(5e5, 0.25, {{"A1", 1}}, {{"A1", 1}})});
  all.push_back({"neo-hookean exact", formed("neo-hookean", "exact", 5e5, 0.25)});
  all.push_back({"corotated", material_of("corotated", 5e5, 0.25)});
  return all;
}

struct Way {
  const char* method;
  const char* preconditioner;
  std::string name() const { return std::string(method) + " " + preconditioner; }
};
constexpr Way ways[] = {{"newton", "diagonal"},  {"newton", "multilevel"}, {"lbfgs", "diagonal"},
                        {"lbfgs", "multilevel"}, {"lbfgs", "direct"},      {"direct", "auto"}};

void choose(Scene& scene, const Way& way) {
  scene.solver.method = way.method;
  scene.solver.preconditioner = way.preconditioner;
  scene.solver.iterations = 3000;
}

/// A bar held at one end, twisted and squeezed, that swings under gravity: 81 particles.
Stage bar(const Material& material, double step = 1. / 60) {
  Stage stage(lattice(9, 3, 3, spacing), spacing, material, step);
  stage.scene.simulation.gravity = {0, -9.81, 0};
  const Vector3 first = stage.model.position[0];
  stage.hold([&](const Vector3& x) { return x.x() < first.x() + 0.5 * spacing; });
  stage.move([&](const Vector3& x) -> Vector3 {
    const Vector3 axis = first + Vector3(0, spacing, spacing), r = x - axis;
    return axis + Eigen::AngleAxisd(0.5 * r.x(), Vector3::UnitX()) * Vector3(0.95 * r.x(), r.y(), r.z());
  });
  return stage;
}

/// The first step of a stage, converged in double.
class Judge {
public:
  explicit Judge(const Stage& stage) : scene_(stage.scene), device_(open_double()) {
    choose(scene_, ways[0]);
    scene_.solver.fixed_iterations = true; // it ends where no descent is left
    for (auto* simulation : {&judge_, &solver_})
      *simulation = std::make_unique<Simulation>(*device_, scene_, stage.model);
    judge_->begin_solving();
    first_ = judge_->potential(judge_->iterate_positions());
    solver_->begin_solving();
    while (!solver_->iterate()) {
    }
    answer_ = solver_->iterate_positions();
    least_ = judge_->potential(answer_);
  }
  double potential(const Points& at) { return judge_->potential(at); }
  double fall() const { return first_ - least_; }
  double error(const Points& at) { return (potential(at) - least_) / fall(); }
  const Points& answer() const { return answer_; }

private:
  Scene scene_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Simulation> judge_, solver_;
  double first_ = 0, least_ = 0;
  Points answer_;
};

class EnergyError : public OnEachDevice {};

// A solve stops where it estimates the asked error; an estimate from the last two falls, or from half the
// slope of the next step, may be off: none was by more than the factor here.
TEST_P(EnergyError, IsBelowTheOneAsked) {
  const auto open = device();
  for (const NamedMaterial& named : materials()) {
    if (GetParam().gl() && named.name != "A4" && named.name != "neo-hookean exact")
      continue; // slow in software
    const Stage stage = bar(named.material);
    Judge judge(stage);
    for (const Way& way : ways) {
      for (const double tolerance : {1e-2, 1e-4, limit(1e-9, 1e-4)}) {
        Scene scene = stage.scene;
        choose(scene, way);
        scene.solver.energy_tolerance = tolerance;
        Simulation simulation(*open, scene, stage.model);
        simulation.begin_solving();
        while (!simulation.iterate()) {
        }
        const double error = judge.error(simulation.iterate_positions());
        simulation.end_solving();
        const StepStatistics row = simulation.take_statistics().back();
        const std::string what = named.name + ", " + way.name() + ", " + std::to_string(row.iterations) +
                                 " iterations: energy error of " + std::to_string(tolerance);
        expect_below(what, error, tolerance);
        EXPECT_EQ(row.reason, StopReason::tolerance) << what;
        EXPECT_LE(row.energy_error, tolerance) << what;
        EXPECT_EQ(row.energy_rises, 0u) << what;
      }
    }
  }
}

// Judged outside the solver, in double: from one iterate to the next.
TEST_P(EnergyError, ThePotentialNeverRises) {
  const auto open = device();
  for (const NamedMaterial& named : materials()) {
    if (GetParam().gl() && named.name != "A4") continue; // slow in software
    const Stage stage = bar(named.material, 1. / 20);
    Judge judge(stage);
    for (const Way& way : ways) {
      Scene scene = stage.scene;
      choose(scene, way);
      scene.solver.energy_tolerance = 1e-5;
      Simulation simulation(*open, scene, stage.model);
      simulation.begin_solving();
      Points last = simulation.iterate_positions();
      double before = judge.potential(last), worst = -1e300;
      int taken = 0;
      for (bool ended = false; !ended;) {
        ended = simulation.iterate(true);
        const Points now = simulation.iterate_positions();
        if (now == last) continue;
        const double potential = judge.potential(now);
        worst = std::max(worst, (potential - before) / judge.fall());
        last = now, before = potential, ++taken;
      }
      simulation.end_solving();
      const StepStatistics row = simulation.take_statistics().back();
      EXPECT_EQ(row.energy_rises, 0u) << named.name << ", " << way.name();
      EXPECT_GE(taken, 2) << named.name << ", " << way.name();
      // What a float's sum over the potential and its positions cannot tell, of the fall.
      expect_below(named.name + ", " + way.name() + ": largest rise, of the fall", worst, limit(1e-12, 1e-5));
    }
  }
}

TEST(EnergyMethods, EndAtTheSamePlace) {
  const auto open = open_double();
  constexpr Way all[] = {ways[0], ways[1], ways[2], ways[3], ways[4], ways[5], {"chebyshev", "auto"}};
  for (const NamedMaterial& named : materials()) {
    const Stage stage = bar(named.material);
    Judge judge(stage);
    for (const Way& way : all) {
      Scene scene = stage.scene;
      choose(scene, way);
      scene.solver.iterations = 20000;
      scene.solver.tolerance = 1e-9;
      Simulation simulation(*open, scene, stage.model);
      simulation.begin_solving();
      while (!simulation.iterate()) {
      }
      // A residual of 1e-9 of the start's, by the root of the condition number, some hundred.
      expect_below(named.name + ", " + way.name() + ": difference, spacings",
                   largest_difference(simulation.iterate_positions(), judge.answer()) / spacing, 1e-6);
    }
  }
}

TEST(EnergyMethods, AutoLeavesCoarseLevelsToStiffScenesAndToLawsWhoseStiffnessStays) {
  const auto chosen = [](const Material& material) {
    Stage stage = bar(material);
    stage.scene.solver.method = "auto";
    stage.scene.solver.energy_tolerance = 1e-4;
    return choose_method(stage.scene, stage.model);
  };
  const Method soft = chosen(basis_of(5e6, 0.25, {{"A4", 1}}, {{"A4", 1}}));
  EXPECT_GT(soft.stiffness_number, 50);
  EXPECT_LT(soft.stiffness_number, 1e4);
  EXPECT_EQ(soft.name, "lbfgs");
  EXPECT_EQ(soft.preconditioner, "diagonal");
  EXPECT_NE(soft.reason.find("saddles"), std::string::npos) << soft.reason;
  const Method stiff = chosen(basis_of(5e10, 0.25, {{"A4", 1}}, {{"A4", 1}}));
  EXPECT_GT(stiff.stiffness_number, 1e4);
  EXPECT_EQ(stiff.preconditioner, "multilevel");
  EXPECT_EQ(chosen(material_of("corotated", 5e6, 0.25)).preconditioner, "multilevel");
}

INSTANTIATE_TEST_SUITE_P(Energy, EnergyError, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
