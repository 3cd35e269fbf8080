// Bodies that break while they move: the same bits whatever the number of threads and whether statistics are
// taken, after a saved state and after a step that had to be taken back; and where the energy goes.
#include "engine/solver/guarded_run.h"
#include "engine/solver/saved_state.h"
#include "tests/failure/broken.h"

#include <cstring>

namespace pliant::test {
namespace {

constexpr double spacing = 0.05;

/// A bar that is drawn at both ends until it parts, 13 x 4 x 4 particles; steps of 1/240 s.
Stage drawn_bar(const Material& material, double speed = 0.6) {
  Stage stage(lattice(13, 4, 4, spacing), spacing, material, 1. / 240);
  stage.scene.solver.tolerance = 1e-3;
  stage.scene.solver.iterations = 40;
  for (const double side : {-1.0, 1.0}) {
    Motion motion;
    motion.velocity = {side * speed, 0, 0};
    stage.hold([&](const Vector3& x) { return side * (x.x() - 6 * spacing) > 4.5 * spacing; }, motion);
  }
  return stage;
}

PlanRequest asked(bool statistics) {
  PlanRequest request;
  request.statistics = statistics;
  request.divergence = true;
  return request;
}

class BreakingBar : public OnEachDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, BreakingBar, testing::ValuesIn(device_choices()), ChoiceName());

TEST_P(BreakingBar, SameBitsForOneThreadAndTwoWithStatisticsAndWithout) {
  for (const Breakable& one : breakable_materials()) {
    const bool both = one.name == "corotated" || one.name == "basis with directions";
    if (GetParam().gl() ? one.name != "corotated" : is_double() && !both) continue; // software GL is slow
    const Stage stage = drawn_bar(one.material);
    const auto narrow = open_alone(GetParam(), 1), wide = open_alone(GetParam(), 2);
    Simulation first(*narrow, stage.scene, stage.model, asked(true)),
        second(*wide, stage.scene, stage.model, asked(false));
    for (int k = 0; k < 80; ++k) first.step(), second.step(); // past a repack, at 64
    const StepStatistics last = first.take_statistics().back();
    std::printf("  %s: %zu bonds broken, %.3g J released\n", one.name.c_str(), last.broken_bonds,
                last.fracture_energy);
    EXPECT_GT(last.broken_bonds, 50u) << one.name;
    EXPECT_GT(last.fracture_energy, 0) << one.name;
    EXPECT_EQ(first.hash(), second.hash()) << one.name;
    EXPECT_EQ(first.damage(), second.damage()) << one.name;
  }
}

// Saved before the first bond broke, between, and after rows of bonds were dropped.
TEST_P(BreakingBar, ASavedStateGoesOnBitForBit) {
  for (const Breakable& one : breakable_materials()) {
    if (one.name != "corotated" && (GetParam().gl() || one.name != "basis with directions")) continue;
    const Stage stage = drawn_bar(one.material);
    const auto open = device();
    Simulation first(*open, stage.scene, stage.model, asked(true));
    std::vector<SavedState> saved;
    for (int k = 0; k < 75; ++k) {
      if (k == 10 || k == 50 || k == 70) saved.push_back(first.save());
      first.step();
    }
    for (const SavedState& state : saved) {
      Simulation second(*open, stage.scene, stage.model, asked(true));
      second.load(state);
      while (second.steps() < 75) second.step();
      EXPECT_EQ(first.hash(), second.hash()) << one.name << " from step " << state.step;
      EXPECT_EQ(first.damage(), second.damage()) << one.name << " from step " << state.step;
    }
  }
}

// Bonds that could break but do not change no bit of the laws over bonds, whose neighbourhoods have no
// rotation.
TEST_P(BreakingBar, WhatDoesNotBreakHasTheBitsOfWhatCannot) {
  const auto open = device();
  for (const char* law : {"ordinary", "basis"}) {
    Material material = material_of(law, 1e5, 0.3);
    if (std::string(law) == "basis") material.volume_basis = material.bond_basis = {{"A2", 1.0}};
    const Stage never = drawn_bar(material);
    material.critical_stretch = 1000;
    const Stage could = drawn_bar(material);
    Simulation first(*open, never.scene, never.model, asked(true)),
        second(*open, could.scene, could.model, asked(true));
    const int steps = GetParam().gl() ? 5 : 66; // past a repack where it is quick
    for (int k = 0; k < steps; ++k) first.step(), second.step();
    EXPECT_EQ(first.hash(), second.hash()) << law;
  }
}

/// Overwrites the velocity of a particle.
void poke(Simulation& simulation, float speed) {
  SavedState state = simulation.save();
  const bool wide = simulation.device().info().precision == Precision::double_precision;
  for (SavedBuffer& buffer : state.buffers) {
    if (buffer.name != "velocity") continue;
    constexpr std::size_t at = std::size_t{4} * 45; // in the middle of the bar
    const double exact = speed;
    if (wide)
      std::memcpy(buffer.bytes.data() + 8 * at, &exact, 8);
    else
      std::memcpy(buffer.bytes.data() + 4 * at, &speed, 4);
  }
  simulation.load(state);
}

// A speed that nothing explains tears its particle out; once the step is taken back its bonds are whole
// again.
TEST_P(BreakingBar, AStepTakenBackRestoresItsBonds) {
  for (const Breakable& one : breakable_materials()) {
    if (one.name != "corotated" && (GetParam().gl() || one.name != "ordinary")) continue;
    const Stage stage = drawn_bar(one.material, 0.01); // too slow to break anything here
    const auto open = device();
    Simulation simulation(*open, stage.scene, stage.model, asked(true));
    GuardedRun run(simulation, stage.scene, stage.model, 4);
    bool poked = false;
    std::size_t most = 0;
    GuardedCalls calls;
    calls.before_step = [&] {
      if (simulation.steps() == 4 && !poked) poke(simulation, 3e5F), poked = true;
      return true;
    };
    calls.after_step = [&] {
      std::size_t damaged = 0;
      for (const double damage : simulation.damage()) damaged += damage > 1e-4;
      most = std::max(most, damaged);
    };
    StepStatistics last;
    while (simulation.steps() < 12) last = run.advance(12, calls).back();
    EXPECT_EQ(run.retries(), 1u);
    EXPECT_GT(most, 5u) << "the poke should tear";
    EXPECT_EQ(last.broken_bonds, 0u) << one.name;
    for (const double damage : simulation.damage()) EXPECT_LT(damage, 1e-4) << one.name;
  }
}

// Kinetic, elastic and released energy of a free bar that flies apart, by BDF2 at small steps.
TEST(BreakingEnergy, IsAccountedFor) {
  const auto open = open_double();
  for (const Breakable& one : breakable_materials()) {
    if (one.name.find(" of bonds") != std::string::npos) continue;
    Material material = one.material;
    material.critical_stretch = 0.05;
    Stage stage(lattice(13, 4, 4, spacing), spacing, material, 2e-4);
    stage.scene.solver.integrator = "bdf2";
    stage.scene.solver.tolerance = 1e-8;
    for (std::size_t i = 0; i < stage.model.count(); ++i)
      stage.model.velocity[i] = {stage.model.position[i].x() < 6.5 * spacing ? -0.5 : 0.5, 0, 0};
    Simulation simulation(*open, stage.scene, stage.model);
    double begun = 0, worst = 0;
    for (std::size_t i = 0; i < stage.model.count(); ++i)
      begun += 0.5 * stage.model.mass[i] * stage.model.velocity[i].squaredNorm();
    for (int k = 0; k < 300; ++k) simulation.step();
    StepStatistics last;
    for (const StepStatistics& row : simulation.take_statistics()) {
      last = row;
      const double sum = row.kinetic_energy + row.elastic_energy + row.fracture_energy;
      worst = std::max(worst, sum / begun - 1); // energy never comes from nothing
    }
    const double sum = last.kinetic_energy + last.elastic_energy + last.fracture_energy;
    std::printf("  %s: of %.4g J kinetic %.4f, elastic %.4f, released %.4f; lost %.4f; %zu bonds broken\n",
                one.name.c_str(), begun, last.kinetic_energy / begun, last.elastic_energy / begun,
                last.fracture_energy / begun, 1 - sum / begun, last.broken_bonds);
    EXPECT_GT(last.fracture_energy / begun, 0.02) << one.name;
    expect_below(one.name + ": energy gained, of the beginning's", worst, 1e-3);
    expect_below(one.name + ": energy lost, of the beginning's", 1 - sum / begun, 0.03);
  }
}

} // namespace
} // namespace pliant::test
