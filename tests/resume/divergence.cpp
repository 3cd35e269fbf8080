// A divergence that is forced on a run is caught, retried in smaller steps and got over; a hopeless one ends
// with the last good state on disk.
#include "engine/core/error.h"
#include "engine/io/checkpoint.h"
#include "engine/io/statistics_writer.h"
#include "engine/report/run.h"
#include "engine/scene/scene_parse.h"
#include "engine/solver/guarded_run.h"
#include "engine/solver/saved_state.h"
#include "tests/program/program.h"
#include "tests/support/devices.h"

#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

using testing::HasSubstr;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t victim = 17;

/// Overwrites the velocity of a particle; at the start of a stretch, as rows on their way are dropped.
void poke(Simulation& simulation, double value) {
  SavedState state = simulation.save();
  for (SavedBuffer& buffer : state.buffers) {
    if (buffer.name != "velocity") continue;
    const bool wide = simulation.device().info().precision == Precision::double_precision;
    for (std::size_t c = 0; c < 3; ++c) {
      const float narrow = static_cast<float>(value);
      if (wide)
        std::memcpy(buffer.bytes.data() + 8 * (4 * victim + c), &value, 8);
      else
        std::memcpy(buffer.bytes.data() + 4 * (4 * victim + c), &narrow, 4);
    }
  }
  simulation.load(state);
}

class Divergence : public testing::TestWithParam<DeviceChoice> {};
INSTANTIATE_TEST_SUITE_P(Devices, Divergence, testing::ValuesIn(device_choices()), ChoiceName());

struct Stage {
  Folder folder;
  Scene scene;
  Model model;
  std::unique_ptr<Device> device;
  explicit Stage(const DeviceChoice& choice, const std::string& integrator = "implicit-euler")
      : scene(
            read_scene(folder.write("small.toml", small_scene),
                       std::vector<std::string>{"solver.integrator=" + integrator, "solver.iterations=24"})),
        model(assemble(scene)), device(choice.open()) {}
  Simulation simulation(bool statistics) {
    PlanRequest request;
    request.statistics = statistics;
    request.divergence = true;
    return {*device, scene, model, request};
  }
};

TEST_P(Divergence, ASavedStateGoesOnBitForBit) {
  for (const char* integrator : {"implicit-euler", "bdf2"}) {
    Stage stage(GetParam(), integrator);
    Simulation first = stage.simulation(true);
    for (int k = 0; k < 31; ++k) first.step(); // past no rebase; the next step is one
    const SavedState saved = first.save();
    for (int k = 0; k < 5; ++k) first.step();
    Simulation second = stage.simulation(false);
    second.load(saved);
    for (int k = 0; k < 5; ++k) second.step();
    EXPECT_EQ(first.hash(), second.hash()) << integrator;
    EXPECT_EQ(second.steps(), 36u);
    second.load(saved);
    second.keep();
    for (int k = 0; k < 3; ++k) second.step();
    second.rewind();
    for (int k = 0; k < 5; ++k) second.step();
    EXPECT_EQ(first.hash(), second.hash()) << integrator;
  }
}

// A velocity that is not a number, once; a speed that nothing explains, once; without statistics too.
TEST_P(Divergence, IsCaughtRetriedAndGotOver) {
  for (const double value : {not_a_number, 3e5})
    for (const bool statistics : {true, false}) {
      Stage stage(GetParam());
      Simulation simulation = stage.simulation(statistics);
      GuardedRun run(simulation, stage.scene, stage.model, 2);
      std::vector<std::string> said;
      bool poked = false;
      GuardedCalls calls;
      calls.before_step = [&] {
        if (simulation.steps() == 4 && !poked) poke(simulation, value), poked = true;
        return true;
      };
      calls.say = [&](const std::string& line) { said.push_back(line); };
      std::vector<std::uint64_t> steps;
      while (simulation.steps() < 12)
        for (const StepStatistics& row : run.advance(12, calls)) {
          steps.push_back(row.step);
          EXPECT_EQ(row.not_finite, 0u);
          EXPECT_LT(row.largest_speed, 20);
        }
      EXPECT_EQ(steps, (std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
      EXPECT_EQ(run.retries(), 1u);
      EXPECT_EQ(run.divided_steps(), 2u);
      ASSERT_EQ(said.size(), 1u);
      EXPECT_THAT(said[0], HasSubstr("back to step 4, each step in 2 parts up to step 6"));
      for (const Vector3& x : simulation.positions()) EXPECT_TRUE(x.allFinite());
      EXPECT_NEAR(simulation.time(), 12 * simulation.time_step(), 1e-12);
    }
}

TEST_P(Divergence, ADividedStepIsAFinerStep) {
  Stage stage(GetParam());
  Simulation whole = stage.simulation(true), parts = stage.simulation(true);
  for (int k = 0; k < 3; ++k) whole.step(), parts.step_divided(4);
  EXPECT_EQ(parts.steps(), 3u);
  const auto rows = parts.take_statistics();
  ASSERT_EQ(rows.size(), 3u);
  // Free fall so far, under implicit Euler: v = g t of both, and the drop g t (t + h) / 2.
  const double t = parts.time(), h = parts.time_step(), y = stage.model.position[victim].y();
  const double g = 9.81, limit = 2e-5;
  EXPECT_NEAR(whole.positions()[victim].y() - y, -g * t * (t + h) / 2, limit);
  EXPECT_NEAR(parts.positions()[victim].y() - y, -g * t * (t + h / 4) / 2, limit);
}

TEST_P(Divergence, AHopelessOneNamesStepBodyAndParticle) {
  Stage stage(GetParam());
  Simulation simulation = stage.simulation(true);
  GuardedRun run(simulation, stage.scene, stage.model, 2);
  GuardedCalls calls;
  calls.before_step = [&] {
    if (simulation.steps() == 4) poke(simulation, not_a_number);
    return true;
  };
  run.advance(12);
  run.advance(12);
  const std::string before = simulation.hash();
  try {
    run.advance(12, calls);
    FAIL() << "a NaN went through";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::diverged);
    EXPECT_THAT(error.what(), HasSubstr("step 5 "));
    EXPECT_THAT(error.what(), HasSubstr("of body 'block'"));
    EXPECT_THAT(error.what(), HasSubstr("no longer finite"));
    EXPECT_THAT(error.what(), HasSubstr("last good state is that of step 4"));
  }
  EXPECT_EQ(run.retries(), 3u);
  EXPECT_EQ(simulation.hash(), before);
}

RunOptions options_of(const Folder& folder) {
  RunOptions options;
  options.scene = folder.write("small.toml", small_scene);
  options.out = folder / "out";
  options.device.backend = "openmp";
  options.render = false;
  options.progress = "none";
  options.frames = 8;
  return options;
}

TEST(DivergedRun, IsRecordedWhereItWasGotOver) {
  const Folder folder;
  RunOptions options = options_of(folder);
  bool poked = false;
  options.before_step = [&](Simulation& simulation) {
    if (simulation.steps() == 8 && !poked) poke(simulation, not_a_number), poked = true;
  };
  EXPECT_EQ(run_scene(options), ExitCode::good);
  const auto record = nlohmann::json::parse(text_of(folder / "out" / "run.json"));
  EXPECT_EQ(record["status"], "finished");
  EXPECT_EQ(record["retries"], 1);
  EXPECT_EQ(record["divided_steps"], 2);
  EXPECT_EQ(record["frames"], 9);
  const auto rows = read_statistics(folder / "out" / "statistics.csv");
  ASSERT_EQ(rows.size(), 16u);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_EQ(rows[k].step, k + 1);
    EXPECT_TRUE(std::isfinite(rows[k].kinetic_energy));
  }
}

TEST(DivergedRun, EndsWithTheLastGoodStateOnDisk) {
  const Folder folder;
  RunOptions options = options_of(folder);
  options.before_step = [&](Simulation& simulation) {
    if (simulation.steps() == 8) poke(simulation, not_a_number);
  };
  try {
    run_scene(options);
    FAIL() << "a NaN went through";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::diverged);
    EXPECT_THAT(error.what(), HasSubstr("step 9 "));
  }
  const auto record = nlohmann::json::parse(text_of(folder / "out" / "run.json"));
  EXPECT_EQ(record["status"], "diverged");
  EXPECT_EQ(record["steps"], 8);
  EXPECT_EQ(record["frames"], 5);
  EXPECT_EQ(record["retries"], 3);
  EXPECT_EQ(read_statistics(folder / "out" / "statistics.csv").size(), 8u);
  EXPECT_EQ(read_checkpoint(folder / "out" / "checkpoints" / "step-00000008.h5").state.step, 8u);
  const std::string command = fmt::format("/usr/bin/python3 {}/tests/readers/check_run.py '{}' 5",
                                          PLIANT_SOURCE_DIR, (folder / "out").string());
  EXPECT_EQ(std::system(command.c_str()), 0);
  // And what diverged goes on from there once the reason is gone.
  options.before_step = {};
  options.resume = true;
  EXPECT_EQ(run_scene(options), ExitCode::good);
}

// From the command line: a speed whose square no float holds.
TEST(DivergedRun, EndsWithFourAndAMessage) {
  const Folder folder;
  std::string text = small_scene;
  text.insert(text.find("[[boundary]]"), "velocity = [1e22, 0, 0]\n");
  const Outcome outcome = pliant(folder, {"run", folder.write("fast.toml", text), "--out", "out", "--backend",
                                          "openmp", "--no-render", "--progress", "none"});
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("of body 'block'"));
  const auto record = nlohmann::json::parse(text_of(folder / "out" / "run.json"));
  EXPECT_EQ(record["status"], "diverged");
}

} // namespace
} // namespace pliant::test
