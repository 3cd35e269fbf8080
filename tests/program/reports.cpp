// What the commands print for programs, and that it says the truth about a scene whose numbers are known.
#include "tests/program/program.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

json parsed(const Outcome& outcome) {
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const json value = json::parse(outcome.out, nullptr, false);
  EXPECT_FALSE(value.is_discarded()) << outcome.out;
  return value.is_discarded() ? json::object() : value;
}

class Reports : public testing::Test {
protected:
  void SetUp() override { folder.write("small.toml", small_scene); }
  Folder folder;
};

TEST_F(Reports, PlanHasItsKeys) {
  const json plan = parsed(pliant(folder, {"plan", "small.toml", "--json"}));
  for (const char* key : {"components", "kernels", "buffers", "bytes_per_particle", "bytes_per_bond"})
    EXPECT_TRUE(plan.contains(key)) << key;
  const Outcome text = pliant(folder, {"plan", "small.toml"});
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.out, HasSubstr("corotated"));
}

TEST_F(Reports, CheckCountsAndWeighs) {
  const json check = parsed(pliant(folder, {"check", "small.toml", "--json", "--backend", "openmp"}));
  EXPECT_EQ(check.at("particles"), 6 * 4 * 4);
  ASSERT_EQ(check.at("bodies").size(), 1u);
  const json body = check.at("bodies")[0];
  EXPECT_EQ(body.at("name"), "block");
  EXPECT_NEAR(body.at("mass"), 1000 * 0.3 * 0.2 * 0.2, 1e-9);
  EXPECT_NEAR(body.at("mesh_volume"), 0.012, 1e-12);
  EXPECT_NEAR(body.at("particle_volume"), 0.012, 1e-12);
  EXPECT_NEAR(body.at("lattice_volume"), 0.012, 1e-12);
  EXPECT_EQ(check.at("steps"), 6);
  EXPECT_EQ(check.at("frames"), 3);
  const double eta = check.at("stiffness_number");
  EXPECT_GT(eta, 0);
  EXPECT_NEAR(check.at("predicted_iterations"), std::max(1.0, std::sqrt(eta / 2) * std::log(2 / 1e-3)), 1e-9);
  EXPECT_GT(check.at("estimate").at("ms_per_iteration"), 0);
  EXPECT_EQ(check.at("estimate").at("backend"), "openmp");
  EXPECT_GT(check.at("memory").at("device_bytes"), 96 * 100);
}

TEST_F(Reports, StiffnessFollowsYoungsModulusAndTheStep) {
  const auto eta = [&](const std::string& set) {
    return parsed(pliant(folder, {"check", "small.toml", "--json", "--backend", "openmp", "--set", set}))
        .at("stiffness_number")
        .get<double>();
  };
  const double base = eta("materials.rubber.young=1e5");
  EXPECT_NEAR(eta("materials.rubber.young=1e6") / base, 10, 1e-9);
  EXPECT_NEAR(eta("simulation.time_step=1/120") / base, 0.25, 1e-9);
}

TEST_F(Reports, CheckWarnsOfABudgetThatCannotDoAndOfLeaps) {
  const Outcome stiff =
      pliant(folder, {"check", "small.toml", "--set", "materials.rubber.young=1e9", "--set",
                      "solver.iterations=20", "--set", "solver.method=chebyshev", "--backend", "openmp"});
  EXPECT_EQ(stiff.code, 0) << stiff.err;
  EXPECT_THAT(stiff.out, HasSubstr("solver.iterations = 20"));
  const Outcome fast =
      pliant(folder, {"check", "small.toml", "--set", "body.block.velocity=[10,0,0]", "--backend", "openmp"});
  EXPECT_EQ(fast.code, 0) << fast.err;
  EXPECT_THAT(fast.out, HasSubstr("contacts may be missed"));
  const Outcome sound = pliant(folder, {"check", "small.toml", "--backend", "openmp"});
  EXPECT_THAT(sound.out, Not(HasSubstr("contacts may be missed")));
  EXPECT_THAT(sound.out, Not(HasSubstr("solver.iterations")));
}

TEST_F(Reports, JsonMayStandBeforeTheSceneAndGoToAFile) {
  EXPECT_TRUE(parsed(pliant(folder, {"plan", "--json", "small.toml"})).contains("kernels"));
  const Outcome outcome = pliant(folder, {"plan", "small.toml", "--json", "plan.json"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_TRUE(json::parse(text_of(folder / "plan.json")).contains("kernels"));
}

TEST_F(Reports, DoctorKnowsTheProcessorAndNamesPackages) {
  const json doctor = parsed(pliant(folder, {"doctor", "--json"}));
  bool openmp = false;
  for (const json& backend : doctor.at("backends")) {
    for (const char* key : {"backend", "name", "software", "usable", "missing"})
      EXPECT_TRUE(backend.contains(key)) << key;
    if (backend.at("backend") == "openmp") openmp = backend.at("usable").get<bool>();
    EXPECT_NE(backend.at("usable").get<bool>(), !backend.at("missing").get<std::string>().empty()) << backend;
  }
  EXPECT_TRUE(openmp);
  EXPECT_TRUE(doctor.at("libraries").contains("HDF5"));
  // Where nothing is found, each thing missing is named with its remedy.
  const Outcome bare = pliant(folder, {"doctor"}, "PATH=/nowhere XDG_CACHE_HOME=/nowhere/cache");
  EXPECT_EQ(bare.code, 0) << bare.err;
  EXPECT_THAT(bare.out, HasSubstr("install ffmpeg"));
  EXPECT_THAT(bare.out, HasSubstr("main-job.sh --meshes"));
  EXPECT_THAT(bare.out, HasSubstr("/nowhere/cache/pliant/meshes"));
}

TEST_F(Reports, SchemaForPeopleAndPrograms) {
  EXPECT_TRUE(parsed(pliant(folder, {"schema", "--json"})).contains("properties"));
  const Outcome text = pliant(folder, {"schema"});
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.out, HasSubstr("spacing"));
}

TEST_F(Reports, ScenesListsThePresentFolder) {
  const json listed = parsed(pliant(folder, {"scenes", "--json"}));
  const json* ours = nullptr;
  for (const json& scene : listed.at("scenes"))
    if (scene.at("file") == "small.toml") ours = &scene;
  ASSERT_NE(ours, nullptr) << listed;
  EXPECT_EQ(ours->at("name"), "small");
  EXPECT_EQ(ours->at("particles"), 96);
  EXPECT_THAT(pliant(folder, {"scenes"}).out, HasSubstr("small.toml"));
}

TEST_F(Reports, NewWritesScenesThatCheckOutAndOverwritesNothing) {
  const Outcome kinds = pliant(folder, {"new"});
  EXPECT_EQ(kinds.code, 0);
  for (const std::string kind : {"drop", "beam"}) {
    EXPECT_THAT(kinds.out, HasSubstr(kind));
    EXPECT_EQ(pliant(folder, {"new", kind}).code, 0);
    const Outcome plan = pliant(folder, {"plan", kind + ".toml"});
    EXPECT_EQ(plan.code, 0) << plan.err;
  }
  folder.write("mine.toml", "precious");
  const Outcome again = pliant(folder, {"new", "drop", "mine.toml"});
  EXPECT_EQ(again.code, 5);
  EXPECT_THAT(again.err, HasSubstr("mine.toml"));
  EXPECT_EQ(text_of(folder / "mine.toml"), "precious");
}

TEST_F(Reports, VerifyFindsTheBackendsAgreed) {
  const Outcome outcome = pliant(
      folder, {"verify", "small.toml", "--steps", "6", "--every", "3", "--iterations", "10", "--json"});
  const json verify = parsed(outcome);
  EXPECT_TRUE(verify.at("run_to_run_identical").get<bool>());
  EXPECT_TRUE(verify.at("threads_identical").get<bool>());
  EXPECT_GE(verify.at("pairs").size(), 1u);
  for (const json& pair : verify.at("pairs")) {
    EXPECT_EQ(pair.at("steps"), 3);
    EXPECT_EQ(pair.at("fields").size(), 2u);
    for (const json& field : pair.at("fields")) {
      const double largest = field.at("max_relative"), median = field.at("median_relative");
      EXPECT_GT(largest, 0)
          << pair; // float is not double: nothing at all would mean that nothing was compared
      EXPECT_LE(largest, 1e-4) << pair;
      EXPECT_LE(median, largest) << pair;
    }
  }
  for (const json& row : verify.at("kernels")) {
    EXPECT_TRUE(row.at("agree").get<bool>()) << row;
    EXPECT_GT(row.at("compared"), 5) << row;
  }
}

TEST_F(Reports, BenchHasItsKeys) {
  const json bench = parsed(pliant(folder, {"bench", "--quick", "--backend", "openmp", "--json"}));
  for (const char* key : {"ceilings", "kernels", "scenes"}) EXPECT_TRUE(bench.contains(key)) << key;
}

} // namespace
} // namespace pliant::test
