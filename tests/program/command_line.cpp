// Help, version, and what a wrong command line or scene gets: an exit code and advice on standard error.
#include "tests/program/program.h"

namespace pliant::test {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

class HelpOf : public testing::TestWithParam<const char*> {};

TEST_P(HelpOf, HasAnExampleThatCallsIt) {
  const Folder folder;
  const Outcome outcome = pliant(folder, {GetParam(), "--help"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("Example"));
  EXPECT_THAT(outcome.out, HasSubstr(std::string("  pliant ") + GetParam()));
  EXPECT_THAT(outcome.err, IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Commands, HelpOf,
                         testing::Values("run", "plan", "check", "verify", "bench", "doctor", "converge",
                                         "stability", "scenes", "new", "schema"),
                         [](const auto& chosen) { return std::string(chosen.param); });

TEST(CommandLine, HelpNamesEveryCommandAndNoneThatIsNotBuilt) {
  const Folder folder;
  const Outcome outcome = pliant(folder, {"--help"});
  EXPECT_EQ(outcome.code, 0);
  for (const char* name : {"run", "plan", "check", "verify", "bench", "doctor", "converge", "stability",
                           "scenes", "new", "schema"})
    EXPECT_THAT(outcome.out, HasSubstr(std::string("\n  ") + name + " ")) << outcome.out;
  for (const char* name : {"render", "export"})
    EXPECT_THAT(outcome.out, Not(HasSubstr(std::string("\n  ") + name + " ")));
}

TEST(CommandLine, VersionIsPrinted) {
  const Folder folder;
  const Outcome outcome = pliant(folder, {"--version"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, StartsWith("pliant "));
}

TEST(CommandLine, FaultsOfTheCommandLineEndWithTwo) {
  const Folder folder;
  const std::string scene = folder.write("small.toml", small_scene);
  struct Case {
    std::vector<std::string> words;
    const char* says;
  };
  const Case cases[] = {
      {{}, "no command"},
      {{"chek", "small.toml"}, "did you mean 'check'"},
      {{"frobnicate"}, "no command"},
      {{"--frobnicate"}, "--frobnicate"},
      {{"run"}, "no scene"},
      {{"plan", "--frobnicate", scene}, "pliant plan --help"},
      {{"run", scene, "--frames", "0"}, "--frames"},
      {{"run", scene, "--frames", "many"}, "--frames"},
      {{"run", scene, "--progress", "loud"}, "--progress"},
      {{"run", scene, "--precision", "half"}, "--precision"},
      {{"run", scene, "--solver", "magic"}, "--solver"},
      {{"check", scene, "--threads", "0"}, "--threads"},
      {{"check", scene, "extra.toml"}, "extra.toml"},
      {{"check", scene, "--backend", "cuda"}, "unknown backend 'cuda'"},
      {{"check", scene, "--backend", "gl:x"}, "gl:x"},
      {{"check", scene, "--set", "simulation.spacng=1"}, "did you mean 'spacing'"},
      {{"new", "drup"}, "did you mean 'drop'"},
      {{"verify", scene, "--steps", "25"}, "multiple"},
  };
  for (const Case& one : cases) {
    const Outcome outcome = pliant(folder, one.words);
    EXPECT_EQ(outcome.code, 2) << testing::PrintToString(one.words) << '\n' << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(one.says)) << testing::PrintToString(one.words);
    EXPECT_THAT(outcome.err, StartsWith("pliant: ")) << testing::PrintToString(one.words);
    EXPECT_THAT(outcome.out, IsEmpty()) << testing::PrintToString(one.words);
  }
}

TEST(CommandLine, FaultsOfASceneHaveFileLineAndColumn) {
  const Folder folder;
  std::string text = small_scene;
  text.replace(text.find("poisson = 0.3"), 13, "poisson = 0.5");
  folder.write("bad.toml", text);
  for (const char* command : {"run", "plan", "check", "verify"}) {
    const Outcome outcome = pliant(folder, {command, "bad.toml"});
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_THAT(outcome.err, HasSubstr("bad.toml:10:")) << command;
    EXPECT_THAT(outcome.err, HasSubstr("poisson")) << command;
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << command;
  }
}

TEST(CommandLine, AMissingSceneIsNamed) {
  const Folder folder;
  for (const char* command : {"run", "plan", "check", "verify"}) {
    const Outcome outcome = pliant(folder, {command, "nowhere.toml"});
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_THAT(outcome.err, HasSubstr("nowhere.toml")) << command;
  }
}

TEST(CommandLine, AMissingMeshIsUsageAndSaysWhereItWasSought) {
  const Folder folder;
  std::string text = small_scene;
  text.replace(text.find("box = [0.3, 0.2, 0.2]"), 21, "mesh = \"nowhere.off\"");
  folder.write("mesh.toml", text);
  const Outcome outcome =
      pliant(folder, {"check", "mesh.toml"}, "XDG_CACHE_HOME=/nowhere/cache PLIANT_MESHES=/nowhere/meshes");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("nowhere.off"));
  EXPECT_THAT(outcome.err, HasSubstr("/nowhere/cache/pliant/meshes"));
  EXPECT_THAT(outcome.err, HasSubstr("/nowhere/meshes"));
}

TEST(CommandLine, ADeviceThatIsNotThereEndsWithThree) {
  const Folder folder;
  folder.write("small.toml", small_scene);
  for (const char* command : {"run", "check"}) {
    const Outcome outcome = pliant(folder, {command, "small.toml", "--backend", "gl:99"});
    EXPECT_EQ(outcome.code, 3) << command << '\n' << outcome.err;
    EXPECT_THAT(outcome.err, AnyOf(HasSubstr("pliant doctor"), HasSubstr("install"))) << command;
  }
}

TEST(CommandLine, AFullDiskEndsWithFive) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const std::string command = std::string("'") + PLIANT_PROGRAM + "' schema >/dev/full 2>/dev/null";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 5);
}

} // namespace
} // namespace pliant::test
