// `pliant converge` on a scene small enough to know what must come out.
#include "tests/program/program.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// small_scene, held at one end, and without the floor.
std::string held_scene() {
  std::string text = small_scene;
  text.resize(text.find("[[boundary]]"));
  return text + "[[body.fixed]]\nregion = { box = [0.08, 1, 1], at = [-0.15, 0, 0] }\n[output]\nfps = 30\n";
}

class Converge : public testing::Test {
protected:
  void SetUp() override { folder.write("held.toml", held_scene()); }
  json run(std::vector<std::string> more) {
    std::vector<std::string> words = {"converge", "held.toml", "--out", "out", "--json", "out.json"};
    words.insert(words.end(), more.begin(), more.end());
    outcome = pliant(folder, words);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const json value = json::parse(text_of(folder / "out.json"), nullptr, false);
    EXPECT_FALSE(value.is_discarded());
    return value.is_discarded() ? json::object() : value;
  }
  Folder folder;
  Outcome outcome;
};

TEST_F(Converge, EverySeriesIsJudgedAgainstAConfirmedReference) {
  const json report = run({"--backend", "openmp", "--seconds", "1", "--only", "newton,chebyshev,jacobi"});
  EXPECT_EQ(report.at("particles"), 6 * 4 * 4);
  EXPECT_GT(report.at("stiffness_number"), 2);
  EXPECT_TRUE(report.at("reference").at("confirmed"));
  EXPECT_LT(report.at("reference").at("agree_max"), 1e-9);
  EXPECT_LT(report.at("reference").at("residual"), 1e-11);
  std::size_t in_double = 0;
  for (const json& series : report.at("series")) {
    const std::string name =
        series.at("method").get<std::string>() + " " + series.at("precision").get<std::string>();
    for (const char* key : {"method", "backend", "precision", "points", "time_to", "setup_ms", "end"})
      EXPECT_TRUE(series.contains(key)) << name << ": " << key;
    const json& points = series.at("points");
    ASSERT_GE(points.size(), 5u) << name;
    const json &first = points.front(), &last = points.back();
    EXPECT_EQ(first.at("iteration"), 0);
    EXPECT_NEAR(first.at("residual"), 1, 1e-3) << name;
    EXPECT_NEAR(first.at("energy_error"), 1, 1e-3) << name;
    for (const char* error : {"residual", "energy_error", "position_rms", "position_max"})
      EXPECT_LT(last.at(error).get<double>(), 1e-3 * first.at(error).get<double>()) << name << ": " << error;
    double before = -1;
    for (const json& point : points) {
      EXPECT_GE(point.at("ms").get<double>(), before) << name;
      EXPECT_GE(point.at("position_max").get<double>(), point.at("position_rms").get<double>());
      before = point.at("ms");
    }
    if (series.at("precision") != "double" || series.at("method") == "jacobi") continue;
    ++in_double;
    EXPECT_LE(last.at("position_rms").get<double>(), 1e-6) << name;
    for (const char* error : {"residual", "energy", "position"}) {
      double shorter = 0;
      for (const int digits : {1, 2, 3, 4, 5, 6}) { // energies go with the square of distances: to 1e-8
        const bool energies = error == std::string("energy");
        if (energies && digits > 4) continue;
        const std::string limit = fmt::format("1e-{}", energies ? 2 * digits : digits);
        const json& ms = series.at("time_to").at(error).at(limit);
        ASSERT_TRUE(ms.is_number()) << name << ": " << error << " " << limit;
        EXPECT_GE(ms.get<double>(), shorter) << name << ": " << error << " " << limit;
        shorter = ms;
      }
    }
  }
  EXPECT_EQ(in_double, 3u); // newton with either preconditioner, chebyshev
  for (const char* file : {"converge.csv", "converge.json", "converge.svg", "converge.png",
                           "converge-residual.svg", "converge-residual.png", "converge-energy.svg"})
    EXPECT_GT(text_of(folder / "out" / file).size(), 100u) << file;
  EXPECT_THAT(text_of(folder / "out" / "converge.csv"),
              testing::StartsWith("method,preconditioner,backend,precision,iteration,ms,residual,"));
  EXPECT_THAT(outcome.out, HasSubstr("confirmed"));
}

TEST_F(Converge, WhatNeverComesIsNull) {
  const json report = run({"--backend", "openmp", "--seconds", "0.2", "--only", "position", "--at", "0"});
  EXPECT_EQ(report.at("step"), 0);
  ASSERT_EQ(report.at("series").size(), 2u);
  EXPECT_TRUE(report.at("series")[0].at("time_to").at("residual").at("1e-6").is_null());
  EXPECT_THAT(outcome.out, HasSubstr("never"));
}

TEST_F(Converge, WholeRunsSplitTheirError) {
  const json report = run({"--run", "--frames", "2"});
  EXPECT_EQ(report.at("frames"), 2);
  const json& steps = report.at("split").at("time");
  ASSERT_GE(steps.size(), 3u);
  for (std::size_t s = 1; s < steps.size(); ++s) // from the longest to the shortest
    EXPECT_LT(steps[s].at("time_error").get<double>(), steps[s - 1].at("time_error").get<double>());
  double loose = -1, tight = -1, budgets = 0;
  for (const json& point : report.at("points")) {
    budgets += point.at("budget").is_number();
    if (point.at("budget").is_number() || point.at("time_step") != report.at("time_step")) continue;
    if (std::abs(point.at("tolerance").get<double>() - 1e-1) < 1e-9) loose = point.at("solver_error");
    if (std::abs(point.at("tolerance").get<double>() - 1e-4) < 1e-9) tight = point.at("solver_error");
  }
  EXPECT_GE(budgets, 5);
  EXPECT_GT(loose, 10 * tight);
  EXPECT_GE(tight, 0);
  EXPECT_TRUE(report.at("pick").contains("tolerance"));
  EXPECT_THAT(outcome.out, HasSubstr("Pick solver.tolerance"));
  for (const char* file : {"converge-run.csv", "converge-run.json", "converge-run.svg", "converge-run.png"})
    EXPECT_GT(text_of(folder / "out" / file).size(), 100u) << file;
}

TEST_F(Converge, BadInputIsRefused) {
  const auto refused = [&](const std::vector<std::string>& more, const std::string& why, int code = 2) {
    std::vector<std::string> words = {"converge", "held.toml"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome bad = pliant(folder, words);
    EXPECT_EQ(bad.code, code) << why;
    EXPECT_THAT(bad.err, HasSubstr(why));
  };
  refused({"--only", "gauss"}, "no method \"gauss\"");
  refused({"--backend", "cuda"}, "unknown backend");
  refused({"--backend", "gl:99"}, "no device gl:99", 3);
  refused({"--at", "100000"}, "ends after");
  refused({"--frames", "2"}, "--frames goes with --run");
  refused({"--run", "--at", "1"}, "--run takes");
  folder.write("file", "");
  refused({"--out", "file"}, "file", 5);
}

} // namespace
} // namespace pliant::test
