// Runs that are killed and resumed end in the bits of the undisturbed run, with files that have no gap and no
// duplicate; checkpoints that do not fit are refused, saying why.
#include "engine/io/folder.h"
#include "engine/io/statistics_writer.h"
#include "tests/program/program.h"

#include <csignal>
#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

namespace pliant::test {
namespace {

using testing::HasSubstr;

/// Two blocks that meet, one of them dragged by a held end, on a floor; long enough to be killed in.
std::string scene_text(const std::string& integrator) {
  return R"(format = 1
name = "killed"
[simulation]
spacing = 0.05
time_step = "1/120"
end = 1.0
[solver]
iterations = 16
integrator = ")" +
         integrator + R"("
[materials.rubber]
density = 1000
young = 2e4
poisson = 0.3
[[body]]
name = "low"
material = "rubber"
shape = { box = [0.25, 0.15, 0.15], at = [0, 0.1, 0] }
[[body.moved]]
region = { box = [0.06, 1, 1], at = [-0.1, 0.1, 0] }
velocity = [0.2, 0, 0]
end = 0.7
[[body]]
name = "high"
material = "rubber"
shape = { box = [0.15, 0.15, 0.15], at = [0.02, 0.32, 0] }
velocity = [0, -1, 0]
[[boundary]]
name = "floor"
shape = { plane = [0, 1, 0], offset = 0 }
friction = 0.4
[output]
fps = 30
fields = ["velocity"]
checkpoint_every = 2
)";
}

pid_t start(const std::vector<std::string>& words, const std::filesystem::path& log) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  ::dup2(file, 1);
  ::dup2(file, 2);
  std::vector<char*> list{const_cast<char*>(PLIANT_PROGRAM)};
  for (const std::string& word : words) list.push_back(const_cast<char*>(word.c_str()));
  list.push_back(nullptr);
  ::execv(PLIANT_PROGRAM, list.data());
  ::_exit(127);
}

/// The exit status, or minus the signal that ended it.
int wait_for(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

nlohmann::json record_of(const std::filesystem::path& run) {
  return nlohmann::json::parse(text_of(run / "run.json"));
}

void expect_rows_without_gap(const std::filesystem::path& run, std::uint64_t steps) {
  const std::vector<StatisticsRow> rows = read_statistics(run / "statistics.csv");
  ASSERT_EQ(rows.size(), steps);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_EQ(rows[k].step, k + 1);
    EXPECT_THAT(rows[k].stopped, testing::AnyOf("tolerance", "floor", "cap"));
  }
}

void expect_files_of(const std::filesystem::path& run, unsigned frames) {
  const std::string command = fmt::format("/usr/bin/python3 {}/tests/readers/check_run.py '{}' {}",
                                          PLIANT_SOURCE_DIR, run.string(), frames);
  EXPECT_EQ(std::system(command.c_str()), 0);
}

struct Setting {
  const char* name;
  const char* backend;
  const char* integrator;
  int frames;
};

class Killed : public testing::TestWithParam<Setting> {};

TEST_P(Killed, TenTimesEndsInTheBitsOfTheUndisturbedRun) {
  const Setting& setting = GetParam();
  const Folder folder;
  const std::string scene = folder.write("killed.toml", scene_text(setting.integrator));
  const auto words = [&](const char* out) {
    return std::vector<std::string>{"run",
                                    scene,
                                    "--out",
                                    (folder / out).string(),
                                    "--backend",
                                    setting.backend,
                                    "--no-render",
                                    "--progress",
                                    "none",
                                    "--frames",
                                    std::to_string(setting.frames)};
  };
  const auto began = std::chrono::steady_clock::now();
  const int undisturbed = wait_for(start(words("whole"), folder / "log"));
  if (undisturbed == 3) GTEST_SKIP() << "no such device";
  ASSERT_EQ(undisturbed, 0) << text_of(folder / "log");
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();

  std::vector<std::string> resumed = words("killed");
  resumed.emplace_back("--resume");
  // Ten moments spread over the run by its own progress, so that a busy machine does not move them.
  std::mt19937 random(20260731);
  std::uniform_real_distribution<> share(0, 1);
  std::vector<double> moments(10);
  for (double& moment : moments) moment = 0.02 + 0.93 * share(random);
  std::sort(moments.begin(), moments.end());
  const auto rows = [&](const char* out) {
    std::error_code none;
    const auto size = std::filesystem::file_size(folder / out / "statistics.csv", none);
    return none ? 0.0 : static_cast<double>(size);
  };
  int kills = 0;
  for (const double moment : moments) {
    const pid_t child = start(resumed, folder / "log");
    siginfo_t ended{};
    while (rows("killed") < moment * rows("whole") && ended.si_pid == 0) {
      std::this_thread::sleep_for(std::chrono::microseconds(500));
      ::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(0.02 * seconds * share(random)));
    ::kill(child, SIGKILL);
    const int status = wait_for(child);
    kills += status == -SIGKILL;
    ASSERT_THAT(status, testing::AnyOf(-SIGKILL, 0)) << text_of(folder / "log");
  }
  EXPECT_GE(kills, 5);
  ASSERT_EQ(wait_for(start(resumed, folder / "log")), 0) << text_of(folder / "log");
  std::printf("%s: %d of 10 were killed in the middle, %.2f s undisturbed\n", setting.name, kills, seconds);

  const nlohmann::json whole = record_of(folder / "whole"), again = record_of(folder / "killed");
  EXPECT_EQ(again["status"], "finished");
  EXPECT_EQ(again["hash"], whole["hash"]);
  EXPECT_EQ(again["frames"], whole["frames"]);
  EXPECT_EQ(again["stopped"], whole["stopped"]);
  EXPECT_EQ(again["iterations"], whole["iterations"]);
  expect_rows_without_gap(folder / "killed", again["steps"]);
  expect_files_of(folder / "killed", again["frames"]);
  EXPECT_EQ(text_of(folder / "killed" / "run.xmf"), text_of(folder / "whole" / "run.xmf"));
}

INSTANTIATE_TEST_SUITE_P(Backends, Killed,
                         testing::Values(Setting{"openmp", "openmp", "implicit-euler", 30},
                                         Setting{"openmp_bdf2", "openmp", "bdf2", 30},
                                         Setting{"gl", "gl", "implicit-euler", 5},
                                         Setting{"gl_bdf2", "gl", "bdf2", 5}),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

/// A short run with pictures left out, and its folder.
struct Short {
  Folder folder;
  std::string scene = folder.write("small.toml", small_scene);
  std::filesystem::path out = folder / "out";
  Outcome run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"run",    scene,         "--out",      out.string(), "--backend",
                                   "openmp", "--no-render", "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    return pliant(folder, words);
  }
  std::vector<std::filesystem::path> checkpoints() const {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(out / "checkpoints"))
      found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
  }
};

void damage(const std::filesystem::path& file) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(static_cast<std::streamoff>(std::filesystem::file_size(file) / 2));
  const char byte = '\x5a';
  for (int k = 0; k < 64; ++k) stream.write(&byte, 1);
}

TEST(Resume, AFinishedRunSaysSoAndMoreFramesAreAdded) {
  const Short s;
  ASSERT_EQ(s.run().code, 0);
  const nlohmann::json first = record_of(s.out);
  const Outcome again = s.run({"--resume"});
  EXPECT_EQ(again.code, 0);
  EXPECT_THAT(again.err, HasSubstr("is finished"));
  EXPECT_EQ(record_of(s.out), first);
  const Outcome more = s.run({"--resume", "--frames", "6"});
  EXPECT_EQ(more.code, 0) << more.err;
  const nlohmann::json longer = record_of(s.out);
  EXPECT_EQ(longer["frames"], 7);
  expect_rows_without_gap(s.out, longer["steps"]);
  expect_files_of(s.out, 7);
  const Short whole;
  ASSERT_EQ(whole.run({"--frames", "6"}).code, 0);
  EXPECT_EQ(record_of(whole.out)["hash"], longer["hash"]);
}

TEST(Resume, WithoutACheckpointStartsAnewButTouchesNoFolderOfOthers) {
  const Short s;
  std::filesystem::create_directories(s.out / "frames");
  write_text_file(s.out / "statistics.csv", "half a line");
  const Outcome outcome = s.run({"--resume"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("no checkpoint: starting anew"));
  const Short other;
  std::filesystem::create_directories(other.out);
  write_text_file(other.out / "thesis.tex", "mine");
  write_text_file(other.out / "statistics.csv", "mine too");
  const Outcome refused = other.run({"--resume"});
  EXPECT_EQ(refused.code, 5);
  EXPECT_EQ(text_of(other.out / "statistics.csv"), "mine too");
}

TEST(Resume, KeepsTheLastTwoAndFallsBackOnTheOlder) {
  const Short s;
  ASSERT_EQ(s.run({"--set", "output.checkpoint_every=1"}).code, 0);
  const std::string hash = record_of(s.out)["hash"];
  const auto kept = s.checkpoints();
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].filename(), "step-00000004.h5");
  EXPECT_EQ(kept[1].filename(), "step-00000006.h5");
  damage(kept[1]);
  std::filesystem::remove(s.out / "run.json"); // as if killed before the end
  const Outcome older = s.run({"--set", "output.checkpoint_every=1", "--resume"});
  EXPECT_EQ(older.code, 0) << older.err;
  EXPECT_THAT(older.err, HasSubstr("step-00000006.h5 is damaged"));
  EXPECT_THAT(older.err, HasSubstr("going on from"));
  EXPECT_EQ(record_of(s.out)["hash"], hash);
  expect_rows_without_gap(s.out, 6);
  expect_files_of(s.out, 4);
  for (const auto& file : s.checkpoints()) damage(file);
  std::filesystem::remove(s.out / "run.json");
  const Outcome none = s.run({"--set", "output.checkpoint_every=1", "--resume"});
  EXPECT_EQ(none.code, 5);
  EXPECT_THAT(none.err, HasSubstr("is damaged"));
}

TEST(Resume, RefusesAnotherSceneDeviceAndBuild) {
  const Short s;
  ASSERT_EQ(s.run().code, 0);
  std::filesystem::remove(s.out / "run.json");
  const Outcome scene = s.run({"--resume", "--set", "materials.rubber.young=2e5"});
  EXPECT_EQ(scene.code, 5);
  EXPECT_THAT(scene.err, HasSubstr("foreign: of another scene"));
  const Outcome device = s.run({"--resume", "--precision", "double"});
  EXPECT_EQ(device.code, 5);
  EXPECT_THAT(device.err, HasSubstr("another device"));
  // The same program with a byte more is another build.
  const auto other = s.folder / "other-pliant";
  std::filesystem::copy_file(PLIANT_PROGRAM, other);
  std::ofstream(other, std::ios::app | std::ios::binary) << 'x';
  const std::string command =
      fmt::format("'{}' run '{}' --out '{}' --backend openmp --no-render --resume 2>'{}'", other.string(),
                  s.scene, s.out.string(), (s.folder / "said").string());
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 5);
  EXPECT_THAT(text_of(s.folder / "said"), HasSubstr("another build"));
  EXPECT_EQ(s.run({"--resume", "--threads", "1"}).code, 0);
}

TEST(Resume, AnInterruptLeavesACheckpoint) {
  const Folder folder;
  const std::string scene = folder.write("killed.toml", scene_text("implicit-euler"));
  const std::vector<std::string> words{"run",
                                       scene,
                                       "--out",
                                       (folder / "out").string(),
                                       "--backend",
                                       "openmp",
                                       "--no-render",
                                       "--set",
                                       "output.checkpoint_every=0",
                                       "--set",
                                       "simulation.end=100",
                                       "--progress",
                                       "none"};
  const pid_t child = start(words, folder / "log");
  while (!std::filesystem::exists(folder / "out" / "statistics.csv") ||
         read_statistics(folder / "out" / "statistics.csv").size() < 10)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ::kill(child, SIGTERM);
  EXPECT_EQ(wait_for(child), 143) << text_of(folder / "log");
  const nlohmann::json stopped = record_of(folder / "out");
  EXPECT_EQ(stopped["status"], "interrupted");
  expect_rows_without_gap(folder / "out", stopped["steps"]);
  expect_files_of(folder / "out", stopped["frames"]);
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "checkpoints" /
                                      fmt::format("step-{:08}.h5", stopped["steps"].get<unsigned>())));
}

} // namespace
} // namespace pliant::test
