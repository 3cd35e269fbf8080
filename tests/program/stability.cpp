// The stability sweep: a handful of its problems, its judge, and the command.
#include "engine/report/stability.h"
#include "engine/io/png.h"
#include "engine/scene/scene_parse.h"
#include "tests/program/program.h"
#include "tests/support/devices.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Stability : public testing::Test {
protected:
  void SetUp() override { scene = read_scene(folder.write("small.toml", small_scene), {}); }
  StabilityReport sweep(const std::string& only, const std::vector<std::string>& backends) {
    StabilityOptions options;
    options.methods = {"chebyshev", "newton"};
    options.backends = backends;
    options.only = only;
    options.particles = 100;
    options.iterations = 60;
    options.jobs = 1;
    return sweep_stability(scene, options);
  }
  StabilitySetup problem(const std::string& name) {
    StabilityOptions options;
    options.particles = 100;
    for (const StabilityProblem& one : stability_problems(scene, options))
      if (one.name == name) return one.build();
    ADD_FAILURE() << "no problem " << name;
    return {};
  }
  Folder folder;
  Scene scene;
};

TEST_F(Stability, ExtremeCellsStayFiniteAndBoundedAndComeBack) {
  for (const char* only :
       {"flattened across", "point", "crushed to", "at 1e4 m/s", "0 iterations", "3 part"}) {
    const StabilityReport report = sweep(only, {"openmp-float", "openmp-double"});
    ASSERT_FALSE(report.cells.empty());
    for (const StabilityCell& cell : report.cells)
      EXPECT_TRUE(cell.good()) << cell.name << ", " << cell.method << ", " << cell.backend << ", E "
                               << cell.young << ": " << cell.message;
    std::printf("  %-20s %2zu cells, %.2f s\n", only, report.cells.size(), report.seconds);
  }
}

TEST_F(Stability, OnGl) {
  bool found = false;
  for (const DeviceChoice& choice : device_choices()) found = found || choice.backend == "gl:0";
  if (!found) GTEST_SKIP() << "no usable GL device";
  const StabilityReport report = sweep("2 iterations", {"gl:0"});
  EXPECT_EQ(report.cells.size(), 4u); // two stiffnesses, two methods
  EXPECT_TRUE(report.good());
}

TEST_F(Stability, FewParticlesFallFreelyAndNoneAreRefused) {
  const StabilityReport one = sweep("1 particle", {"openmp-float"}),
                        none = sweep("no particle", {"openmp-float"});
  ASSERT_EQ(one.cells.size(), 2u);
  EXPECT_TRUE(one.cells[0].recovery_wanted && one.cells[0].recovered) << one.cells[0].message;
  ASSERT_EQ(none.cells.size(), 2u);
  EXPECT_TRUE(none.cells[0].refused && none.cells[0].good());
  EXPECT_THAT(none.cells[0].message, HasSubstr("no particles"));
}

TEST_F(Stability, TheJudgeConvicts) {
  const StabilitySetup setup = problem("flattened");
  ASSERT_EQ(setup.wanted, Wanted::shape);
  const std::vector<Vector3>& rest = setup.model.position;
  StabilityCell cell;
  StabilityWatch back(setup, 1);
  back.after(1, 0.01, rest);
  back.judge(cell);
  EXPECT_TRUE(cell.finite && cell.bounded && cell.recovered) << cell.message;
  EXPECT_LT(cell.strain, 1e-12);

  StabilityWatch flat(setup, 1);
  flat.after(1, 0.01, setup.position);
  flat.judge(cell);
  EXPECT_TRUE(cell.finite && cell.bounded);
  EXPECT_FALSE(cell.recovered);

  std::vector<Vector3> wrong = rest;
  for (Vector3& y : wrong) y.x() = 2 * rest[0].x() - y.x();
  StabilityWatch mirrored(setup, 1);
  mirrored.after(1, 0.01, wrong);
  mirrored.judge(cell);
  EXPECT_EQ(cell.upright, 0);
  EXPECT_LT(cell.strain, 1e-12);
  EXPECT_FALSE(cell.recovered);

  wrong = rest;
  wrong[3] += Vector3(0, 11 * setup.size, 0);
  StabilityWatch far(setup, 2);
  far.after(1, 0.01, wrong);
  far.after(2, 0.01, rest);
  far.judge(cell);
  EXPECT_TRUE(cell.finite);
  EXPECT_FALSE(cell.bounded);

  wrong[3].z() = std::numeric_limits<double>::quiet_NaN();
  StabilityWatch broken(setup, 1);
  EXPECT_FALSE(broken.after(1, 0.01, wrong));
  broken.judge(cell);
  EXPECT_FALSE(cell.finite || cell.bounded || cell.recovered);
}

TEST_F(Stability, FlightIsJudgedFromTheBallisticCentre) {
  StabilitySetup setup = problem("flies at 1e4 m/s");
  const double h = setup.scene.simulation.time_step;
  std::vector<Vector3> y = setup.position;
  for (Vector3& x : y) x += 2 * h * Vector3(6e3, 8e3, 0);
  StabilityCell cell;
  StabilityWatch along(setup, 2);
  along.after(2, h, y);
  along.judge(cell);
  EXPECT_TRUE(cell.bounded && cell.recovered) << cell.message;
  StabilityWatch stays(setup, 2);
  stays.after(2, h, setup.position);
  stays.judge(cell);
  EXPECT_FALSE(cell.bounded);
}

TEST_F(Stability, TheCommandWritesItsFiles) {
  const Outcome outcome =
      pliant(folder, {"stability", "small.toml", "--only", "1 iterations", "--methods", "newton,auto",
                      "--backend", "openmp-double", "--out", "found", "--json"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  ASSERT_EQ(report.at("cells").size(), 4u);
  for (const char* key : {"case", "young", "poisson", "time_step", "method", "backend", "finite", "bounded",
                          "recovered", "iterations", "restarts"})
    EXPECT_TRUE(report["cells"][0].contains(key)) << key;
  EXPECT_LE(report["cells"][0]["iterations"], 2 * 60); // of each step: the first evaluation, and one more
  for (const char* key : {"cells", "non_finite", "unbounded", "unrecovered"})
    EXPECT_TRUE(report.at("summary").contains(key)) << key;
  EXPECT_EQ(report["summary"]["cells"], 4);
  const std::string csv = text_of(folder / "found/stability.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
  EXPECT_EQ(json::parse(text_of(folder / "found/stability.json"))["summary"], report["summary"]);
  EXPECT_GT(read_png(folder / "found/stability.png").width, 600u);
  EXPECT_THAT(text_of(folder / "found/stability.svg"), HasSubstr("1 iterations"));
}

TEST_F(Stability, TheCommandRefuses) {
  const Outcome method = pliant(folder, {"stability", "small.toml", "--methods", "magic", "--out", "a"});
  EXPECT_EQ(method.code, 2);
  EXPECT_THAT(method.err, HasSubstr("chebyshev"));
  const Outcome backend = pliant(folder, {"stability", "small.toml", "--backend", "abacus", "--out", "b"});
  EXPECT_EQ(backend.code, 3);
  EXPECT_THAT(backend.err, HasSubstr("openmp-double"));
  const Outcome name = pliant(folder, {"stability", "small.toml", "--only", "nonsense", "--out", "c"});
  EXPECT_EQ(name.code, 2);
  EXPECT_THAT(name.err, HasSubstr("nonsense"));
}

} // namespace
} // namespace pliant::test
