// The program on scenes with emitters: what it writes, how it goes on, and how a full scene ends.
#include "engine/io/statistics_writer.h"
#include "tests/program/program.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

using testing::HasSubstr;

/// A tap that fills a tray, the overflow of which is taken out.
std::string tap(const std::string& when_full) {
  return R"(format = 1
name = "tap"
[simulation]
spacing = 0.05
time_step = "1/60"
end = 1
capacity = 60
[materials.water]
model = "fluid"
[[emitter]]
name = "tap"
material = "water"
nozzle = { disc = 0.1 }
at = [0, 0.5, 0]
speed = 1
when_full = ")" +
         when_full + R"("
[[boundary]]
shape = { plane = [0, 1, 0], offset = 0 }
[[sink]]
name = "drain"
region = { box = [0.4, 0.2, 0.4], at = [0.2, 0.1, 0] }
[output]
fps = 60
checkpoint_every = 5
fields = ["velocity"]
)";
}

Outcome run(const Folder& folder, const std::string& scene, const std::string& out, int frames,
            bool resume = false) {
  std::vector<std::string> words{
      "run",  scene,         "--out",    (folder / out).string(), "--backend", "openmp", "--progress",
      "none", "--no-render", "--frames", std::to_string(frames)};
  if (resume) words.emplace_back("--resume");
  return pliant(folder, words);
}

nlohmann::json record_of(const std::filesystem::path& run) {
  return nlohmann::json::parse(text_of(run / "run.json"));
}

void expect_readable(const std::filesystem::path& run, int frames) {
  const std::string command = fmt::format("/usr/bin/python3 {}/tests/readers/check_run.py '{}' {}",
                                          PLIANT_SOURCE_DIR, run.string(), frames);
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(EmitterRuns, GoOnAndAddUp) {
  const Folder folder;
  const std::string scene = folder.write("tap.toml", tap("stop"));
  ASSERT_EQ(run(folder, scene, "whole", 40).code, 0);
  ASSERT_EQ(run(folder, scene, "parts", 23).code, 0);
  ASSERT_EQ(run(folder, scene, "parts", 40, true).code, 0);
  const nlohmann::json whole = record_of(folder / "whole"), parts = record_of(folder / "parts");
  EXPECT_EQ(whole["hash"], parts["hash"]);
  const std::vector<StatisticsRow> rows = read_statistics(folder / "whole" / "statistics.csv");
  ASSERT_EQ(rows.size(), 40u);
  for (const StatisticsRow& row : rows) {
    ASSERT_TRUE(row.flow && row.fluid);
    EXPECT_EQ((*row.flow)[0] - (*row.flow)[1], (*row.flow)[2]);
  }
  const nlohmann::json& fluid = whole["fluid"];
  EXPECT_EQ(fluid["emitted"], (*rows.back().flow)[0]);
  EXPECT_EQ(fluid["emitters"]["tap"]["emitted"], fluid["emitted"]);
  EXPECT_EQ(fluid["sinks"]["drain"], fluid["sunk"]);
  EXPECT_GT(fluid["sunk"], 0);
  expect_readable(folder / "whole", 41); // nothing is there in the first
  expect_readable(folder / "parts", 41);
}

TEST(EmitterRuns, FullScenesKeepWhatTheyComputed) {
  const Folder folder;
  std::string text = tap("error");
  text.erase(text.find("[[sink]]"), text.find("[output]") - text.find("[[sink]]"));
  const std::string scene = folder.write("tap.toml", text);
  const Outcome outcome = run(folder, scene, "full", 60);
  EXPECT_EQ(outcome.code, 6);
  EXPECT_THAT(outcome.err, HasSubstr("tap.toml:13:10: emitter 'tap': there is no room for its next 12 "
                                     "particles at t = 0.25 s: the scene may hold 60"));
  EXPECT_THAT(outcome.err, HasSubstr("what was computed up to step 15 (t = 0.25 s)"));
  const nlohmann::json record = record_of(folder / "full");
  EXPECT_EQ(record["status"], "full");
  EXPECT_EQ(record["steps"], 15);
  const std::vector<StatisticsRow> rows = read_statistics(folder / "full" / "statistics.csv");
  ASSERT_EQ(rows.size(), 15u);
  EXPECT_EQ((*rows.back().flow)[2], 60);
  expect_readable(folder / "full", 16);
}

} // namespace
} // namespace pliant::test
