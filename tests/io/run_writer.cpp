// run.vtkhdf and run.xmf: judged by a reader that is not ours (h5py, and ParaView where it is installed),
// after a normal end, after a kill, and after a full disk.
#include "engine/io/run_writer.h"

#include "engine/core/error.h"
#include "engine/io/folder.h"
#include "engine/io/hdf5.h"
#include "tests/io/support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <limits>
#include <sys/resource.h>
#include <sys/wait.h>

using namespace pliant;
using pliant::test::check_run;
using pliant::test::ScratchFolder;
using testing::HasSubstr;

namespace {

BodyOutput cloud(const std::string& name, std::size_t points) {
  return {name, BodyOutput::Kind::particles, points, {}, {{"velocity", 3}, {"damage", 1}}};
}

BodyOutput surface(const std::string& name) {
  return {name, BodyOutput::Kind::surface, 4, {{0, 1, 2}, {1, 3, 2}}, {{"strain", 1}}};
}

// Every value names its frame, body, point and component, so that a misplaced one shows.
std::vector<float> values(std::size_t points, unsigned components, std::uint64_t frame, float body) {
  std::vector<float> all(points * components);
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = static_cast<float>(frame) * 1000 + body * 100 + static_cast<float>(i) / 8;
  return all;
}

// Frames of a cloud of `sizes[frame]` points and, where asked, of a surface.
void append_frame(RunWriter& run, std::uint64_t frame, std::size_t points, bool with_surface) {
  const auto p = values(points, 3, frame, 1), v = values(points, 3, frame, 2),
             d = values(points, 1, frame, 3);
  const auto q = values(4, 3, frame, 4), s = values(4, 1, frame, 5);
  std::vector<BodyFrame> bodies = {{p, {v, d}}};
  if (with_surface) bodies.push_back({q, {s}});
  run.append(frame, bodies);
}

// What a child does in a process of its own; its exit status, or minus the signal that ended it.
template <class F> int in_child(F&& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    int status = 99;
    try {
      status = work();
    } catch (const Error& error) {
      std::fprintf(stderr, "%s\n", error.what());
      std::fflush(stderr);
      status = static_cast<int>(error.code());
    }
    ::_exit(status);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

} // namespace

TEST(RunWriter, TwoBodiesSatisfyEveryRuleOfTheLayout) {
  ScratchFolder folder;
  RunWriter run(folder.path, {cloud("sand", 6), surface("ball_surface")}, 30);
  const std::size_t sizes[] = {5, 0, 700, 8, 2};
  for (std::uint64_t k = 0; k < 5; ++k) append_frame(run, k, sizes[k], true);
  EXPECT_EQ(run.frames(), 5u);
  run.close();
  const auto answer = check_run(folder.path, 5);
  EXPECT_EQ(answer.status, 0) << answer.text;
  EXPECT_THAT(answer.text, HasSubstr("2 blocks, 5 frames"));

  // And the values themselves, read back from frame 3: its rows of the flat array start after 5 + 0 + 700
  // points.
  const h5::File file = h5::File::open(folder.path / "run.vtkhdf");
  const auto wanted = values(8, 3, 3, 2);
  EXPECT_EQ(file.root().dataset("/VTKHDF/sand/PointData/velocity").read<float>(705, 8), wanted);
  EXPECT_EQ(file.root().dataset("/frames/000003/sand/velocity").read<float>(), wanted);
  EXPECT_EQ(file.root().group("VTKHDF").names(),
            (std::vector<std::string>{"Assembly", "sand", "ball_surface"}));
}

// Of a surface that tears each frame has what is left, also none; a run that is gone on with from a mark as
// well.
TEST(RunWriter, ASurfaceTears) {
  const std::vector<std::vector<std::uint32_t>> torn{{0, 0}, {0, 0}, {1, 0}, {1, 0}, {1, 1}, {1, 1}};
  for (const std::size_t stop : {torn.size(), std::size_t{2}, std::size_t{4}, std::size_t{5}}) {
    ScratchFolder folder;
    BodyOutput ball = surface("ball_surface");
    ball.tears = true;
    const auto append = [&](RunWriter& run, std::uint64_t k) {
      const auto p = values(6, 3, k, 1), v = values(6, 3, k, 2), d = values(6, 1, k, 3);
      const auto q = values(4, 3, k, 4), s = values(4, 1, k, 5);
      run.append(k, {{p, {v, d}}, {q, {s}, torn[k]}});
    };
    {
      RunWriter run(folder.path, {cloud("sand", 6), ball}, 30);
      for (std::uint64_t k = 0; k < stop; ++k) append(run, k);
      const RunMark mark = run.mark();
      if (stop < torn.size()) append(run, stop); // lost again
      run.close();
      if (stop < torn.size()) {
        RunWriter more(folder.path, {cloud("sand", 6), ball}, 30, mark);
        for (std::uint64_t k = stop; k < torn.size(); ++k) append(more, k);
        more.close();
      }
    }
    const auto answer = check_run(folder.path, static_cast<int>(torn.size()));
    EXPECT_EQ(answer.status, 0) << answer.text;
    const h5::File file = h5::File::open(folder.path / "run.vtkhdf");
    const h5::Group top = file.root().group("VTKHDF").group("ball_surface");
    EXPECT_EQ(top.dataset("Polygons/NumberOfCells").read<std::int64_t>(),
              (std::vector<std::int64_t>{2, 1, 0}));
    EXPECT_EQ(file.root().dataset("/frames/000001/ball_surface/corners").read<std::int64_t>(),
              (std::vector<std::int64_t>{0, 1, 2, 1, 3, 2}));
    EXPECT_EQ(file.root().dataset("/frames/000003/ball_surface/corners").read<std::int64_t>(),
              (std::vector<std::int64_t>{1, 3, 2}));
    EXPECT_FALSE(file.root().has("/frames/000005/ball_surface/corners"));
  }
}

TEST(RunWriter, OneBodyLiesAtTheTop) {
  ScratchFolder folder;
  RunWriter run(folder.path, {cloud("sand", 300)}, 24);
  for (std::uint64_t k = 0; k < 3; ++k) append_frame(run, 2 * k, 300, false);
  run.close();
  const auto answer = check_run(folder.path, 3);
  EXPECT_EQ(answer.status, 0) << answer.text;
  const h5::File file = h5::File::open(folder.path / "run.vtkhdf");
  EXPECT_EQ(file.root().dataset("/VTKHDF/Steps/Values").read<double>(),
            (std::vector<double>{0, 2.0 / 24, 4.0 / 24}));
}

TEST(RunWriter, EqualRunsWriteEqualBytes) {
  ScratchFolder a, b;
  for (const ScratchFolder* folder : {&a, &b}) {
    RunWriter run(folder->path, {cloud("sand", 6), surface("ball_surface")}, 30);
    for (std::uint64_t k = 0; k < 3; ++k) append_frame(run, k, 6 + k, true);
    run.close();
  }
  EXPECT_TRUE(read_text_file(a.path / "run.vtkhdf") == read_text_file(b.path / "run.vtkhdf"));
  EXPECT_EQ(read_text_file(a.path / "run.xmf"), read_text_file(b.path / "run.xmf"));
}

// The judge itself must be able to convict.
TEST(RunWriter, TheCheckerFindsADamagedFile) {
  ScratchFolder folder;
  {
    RunWriter run(folder.path, {cloud("sand", 6), surface("ball_surface")}, 30);
    for (std::uint64_t k = 0; k < 3; ++k) append_frame(run, k, 6, true);
    run.close();
  }
  EXPECT_EQ(check_run(folder.path, 3).status, 0);
  EXPECT_EQ(check_run(folder.path, 4).status, 1);
  {
    h5::File file = h5::File::open(folder.path / "run.vtkhdf", true);
    h5::Group steps = file.root().group("/VTKHDF/sand/Steps");
    steps.set_attribute<std::int64_t>("NSteps", 2);
  }
  const auto answer = check_run(folder.path, 3);
  EXPECT_EQ(answer.status, 1);
  EXPECT_THAT(answer.text, HasSubstr("/VTKHDF/sand/Steps/Values has 3 rows, NSteps is 2"));
}

TEST(RunWriter, ParaViewReadsEveryFrame) {
  if (test::run_program("command -v pvpython").status != 0) GTEST_SKIP() << "pvpython is not installed";
  ScratchFolder folder;
  RunWriter run(folder.path, {cloud("sand", 6), surface("ball_surface")}, 30);
  const std::size_t sizes[] = {5, 3, 700, 8};
  for (std::uint64_t k = 0; k < 4; ++k) append_frame(run, k, sizes[k], true);
  run.close();
  const std::string display = test::run_program("command -v xvfb-run").status == 0 ? "xvfb-run -a " : "";
  const auto answer = test::run_program(
      display + "timeout 120 pvpython " PLIANT_SOURCE_DIR "/tests/readers/check_paraview.py '" +
      folder.path.string() + "'");
  EXPECT_EQ(answer.status, 0) << answer.text;
}

TEST(RunWriter, RefusesWhatIsNotFiniteAndKeepsTheFramesBefore) {
  ScratchFolder folder;
  RunWriter run(folder.path, {cloud("sand", 6)}, 30);
  append_frame(run, 0, 6, false);
  auto p = values(6, 3, 1, 1), v = values(6, 3, 1, 2), d = values(6, 1, 1, 3);
  v[3 * 4 + 1] = std::numeric_limits<float>::quiet_NaN();
  try {
    run.append(1, {{p, {v, d}}});
    FAIL() << "a NaN was written";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::diverged);
    EXPECT_THAT(error.what(), HasSubstr("velocity of particle 4 of body \"sand\" is nan in frame 1"));
  }
  v[13] = 0;
  p[0] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(run.append(1, {{p, {v, d}}}), Error);
  append_frame(run, 1, 6, false); // nothing of the refused frame is in the way
  run.close();
  const auto answer = check_run(folder.path, 2);
  EXPECT_EQ(answer.status, 0) << answer.text;
}

TEST(RunWriter, RefusesNamesAndFramesThatReadersCannotTake) {
  ScratchFolder folder;
  for (const char* name : {"", "a/b", "a.b", "two words", "1st", "Assembly"})
    EXPECT_THROW(RunWriter(folder.path, {cloud(name, 1)}, 30), Error) << name;
  EXPECT_THROW(RunWriter(folder.path, {cloud("a", 1), cloud("a", 1)}, 30), Error);
  EXPECT_THROW(RunWriter(folder.path, {cloud("a", 1)}, 0), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
  RunWriter run(folder.path, {cloud("a", 1)}, 30);
  append_frame(run, 4, 1, false);
  EXPECT_THROW(append_frame(run, 4, 1, false), Error);
}

TEST(RunWriter, AKilledRunLeavesItsFrames) {
  ScratchFolder folder;
  const int status = in_child([&]() -> int {
    RunWriter run(folder.path, {cloud("sand", 100), surface("ball_surface")}, 30);
    for (std::uint64_t k = 0; k < 7; ++k) append_frame(run, k, 100 + 40 * k, true);
    ::raise(SIGKILL);
    return 0;
  });
  EXPECT_EQ(status, -SIGKILL);
  const auto answer = check_run(folder.path, 7);
  EXPECT_EQ(answer.status, 0) << answer.text;
}

TEST(RunWriter, AFileCanBeReadWhileItIsWritten) {
  ScratchFolder folder;
  RunWriter run(folder.path, {cloud("sand", 100)}, 30);
  append_frame(run, 0, 100, false);
  append_frame(run, 1, 90, false);
  const auto answer = check_run(folder.path, 2);
  EXPECT_EQ(answer.status, 0) << answer.text;
  append_frame(run, 2, 90, false);
}

// A limit on the size of files stands in for a full disk.
TEST(RunWriter, AFullDiskIsAnErrorAndKeepsTheFramesBefore) {
  ScratchFolder folder;
  const int status = in_child([&]() -> int {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {2 << 20, 2 << 20};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::freopen((folder.path / "said").c_str(), "w", stderr);
    RunWriter run(folder.path, {cloud("sand", 4000), surface("ball_surface")}, 30);
    for (std::uint64_t k = 0; k < 100; ++k) append_frame(run, k, 4000, true);
    return 0;
  });
  EXPECT_EQ(status, static_cast<int>(ExitCode::input_output));
  EXPECT_THAT(read_text_file(folder.path / "said"), HasSubstr("run.vtkhdf: File too large; free some space"));
  const h5::File file = h5::File::open(folder.path / "run.vtkhdf");
  const auto frames = static_cast<int>(file.root().dataset("/VTKHDF/sand/Steps/Values").rows());
  EXPECT_GT(frames, 3);
  const auto answer = check_run(folder.path, frames);
  EXPECT_EQ(answer.status, 0) << answer.text;
}

TEST(RunWriter, AFolderThatIsNotThereIsAnError) {
  try {
    RunWriter run("/nowhere/at/all", {cloud("sand", 1)}, 30);
    FAIL() << "wrote into a folder that does not exist";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input_output);
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/at/all/run.vtkhdf"));
    EXPECT_THAT(error.what(), HasSubstr("No such file or directory"));
  }
}
