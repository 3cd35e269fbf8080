// A scene that does not fit this machine's memory is refused, with what it needs and what would do.
#include "engine/core/memory.h"
#include "engine/core/error.h"
#include "engine/model/model.h"
#include "engine/scene/scene.h"

#include <cmath>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace pliant::test {
namespace {

using testing::HasSubstr;

TEST(Memory, TheSpacingThatIsNamedFits) {
  require_memory("it needs", 1e9, 1e9, 0.01);
  try {
    require_memory("it needs", 8e9, 1e9, 0.01);
    FAIL() << "8 GB fit into 1 GB";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::too_large);
    EXPECT_STREQ(error.what(), "it needs about 8 GB of memory, and 1 GB are free; a spacing of 0.02 m would "
                               "do instead of 0.01 m");
  }
  try {
    require_memory("it needs", 5e8, 1e8, 0.013);
    FAIL() << "500 MB fit into 100 MB";
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_THAT(text, HasSubstr("about 500 MB of memory, and 100 MB are free"));
    const double named = std::stod(text.substr(text.find("spacing of ") + 11));
    EXPECT_LE(5e8 * std::pow(0.013 / named, 3), 1e8);
    EXPECT_LT(named, 0.013 * std::cbrt(5.0) * 1.1);
  }
}

// In a child: this process keeps its limits.
TEST(Memory, UlimitCountsAndTheSceneIsRefused) {
  EXPECT_GT(available_memory(), 1e6);
  const pid_t child = ::fork();
  if (child == 0) {
    std::FILE* file = std::fopen("/proc/self/statm", "r");
    double pages = 0;
    if (!file || std::fscanf(file, "%lf", &pages) != 1) ::_exit(100);
    std::fclose(file);
    const rlim_t room = rlim_t{200} << 20;
    const rlimit limit = {static_cast<rlim_t>(pages * static_cast<double>(::sysconf(_SC_PAGESIZE))) + room,
                          RLIM_INFINITY};
    if (::setrlimit(RLIMIT_AS, &limit) != 0) ::_exit(101);
    if (available_memory() > static_cast<double>(room)) ::_exit(102);
    Scene scene;
    scene.simulation.spacing = 0.01;
    scene.materials.resize(1);
    scene.materials[0].name = "clay";
    Body body;
    body.name = "block";
    body.material = "clay";
    body.shape.kind = Shape::Kind::box;
    body.shape.size = {1, 1, 0.5}; // 500,000 particles: 1.3 GB
    scene.bodies.push_back(body);
    try {
      assemble(scene);
    } catch (const Error& error) {
      const std::string text = error.what();
      ::_exit(text.find("5e+05 particles of about 27 neighbours") == std::string::npos
                  ? 103
                  : static_cast<int>(error.code()));
    } catch (...) {
      ::_exit(104);
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), static_cast<int>(ExitCode::too_large));
}

} // namespace
} // namespace pliant::test
