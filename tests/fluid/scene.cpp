// Scenes of fluids: their keys, and what is said of wrong ones.
#include "engine/model/ghosts.h"
#include "engine/scene/scene_json.h"
#include "engine/scene/scene_schema.h"
#include "tests/scene/parse.h"

#include <nlohmann/json.hpp>

namespace pliant {
namespace {

using testing::HasSubstr;

const std::string water = "[simulation]\n"
                          "spacing = 0.1\n"
                          "[materials.water]\n"
                          "model = \"fluid\"\n"
                          "viscosity = 0.5\n"
                          "redistribution = 0.25\n"
                          "surface_tension = 0.02\n"
                          "[[body]]\n"
                          "name = \"pool\"\n"
                          "material = \"water\"\n"
                          "shape = { box = [1, 1, 1] }\n";

TEST(FluidScene, KeysAreRead) {
  std::string text = water;
  text.insert(text.find("surface_tension"), "tensile_strength = 300\n");
  const Scene scene =
      parsed(text + "[fluid]\nhorizon = 2.6\ndensity_iterations = 7\nneighbours = 80\n"
                    "viscosity_form = \"central\"\n"
                    "[domain]\nlow = [-2, -1, -1]\nhigh = [2, 1, 1]\nperiodic = [true, false, true]\n");
  ASSERT_TRUE(scene.flows());
  EXPECT_EQ(scene.materials[0].viscosity, 0.5);
  EXPECT_EQ(scene.materials[0].redistribution, 0.25);
  EXPECT_EQ(scene.materials[0].surface_tension, 0.02);
  EXPECT_EQ(scene.materials[0].tensile_strength, 300);
  EXPECT_EQ(scene.fluid.horizon, 2.6);
  EXPECT_EQ(scene.fluid.density_iterations, 7u);
  EXPECT_EQ(scene.fluid.neighbours, 80u);
  EXPECT_EQ(scene.fluid.viscosity_form, "central");
  EXPECT_EQ(parsed(water).fluid.viscosity_form, "laplacian");
  EXPECT_TRUE(scene.domain.given);
  EXPECT_EQ(scene.domain.low.x(), -2);
  EXPECT_EQ(scene.domain.periodic, (std::array{true, false, true}));
  const nlohmann::json json = scene_to_json(scene);
  EXPECT_EQ(json["fluid"]["density_iterations"], 7);
  EXPECT_EQ(json["domain"]["periodic"], nlohmann::json({true, false, true}));
  EXPECT_EQ(json["materials"]["water"]["viscosity"], 0.5);
  EXPECT_FALSE(json["materials"]["water"].contains("young"));
  EXPECT_FALSE(scene_to_json(parsed(small_scene)).contains("fluid"));
  EXPECT_FALSE(scene_to_json(parsed(small_scene)).contains("domain"));
}

TEST(FluidScene, WrongOnesAreRefused) {
  const auto with = [](const std::string& more) { return complaint(water + more); };
  const std::string material = "[materials.water]\nmodel = \"fluid\"\n";
  const auto in_material = [&](const std::string& line) {
    std::string text = water;
    return complaint(text.replace(text.find("viscosity = 0.5"), 15, line));
  };
  EXPECT_EQ(complaint(water), "");
  EXPECT_THAT(in_material("tensile_strength = -1"),
              HasSubstr("s.toml:5:20: materials.water.tensile_strength = -1 is out of range"));
  EXPECT_THAT(in_material("viscosity = -1"),
              HasSubstr("s.toml:5:13: materials.water.viscosity = -1 is out of range"));
  EXPECT_THAT(in_material("redistribution = 2"), HasSubstr("redistribution"));
  EXPECT_THAT(in_material("young = 1e5"),
              HasSubstr("s.toml:5:1: materials.water.young is one of elastic materials"));
  EXPECT_THAT(in_material("plastic = { cohesion = 1 }"),
              HasSubstr("materials.water.plastic is one of elastic"));
  EXPECT_THAT(
      complaint(with_line(4, "viscosity = 1")),
      HasSubstr(
          "s.toml:4:1: materials.rubber.viscosity applies to models \"fluid\" and \"viscoelastic\" only"));
  EXPECT_THAT(with("fixed = [{ region = { box = [1, 1, 1] } }]\n"),
              HasSubstr("s.toml:12:1: body.0.fixed is for solids"));
  EXPECT_THAT(with("start = \"flat\"\n"), HasSubstr("body.0.start is for solids"));
  EXPECT_THAT(with("[materials.rubber]\n[[body]]\nmaterial = \"rubber\"\nshape = { sphere = 1 }\n"),
              HasSubstr("s.toml:14:12: body.1 is elastic and another is a fluid"));
  EXPECT_THAT(
      with("region = [{ region = { box = [1, 1, 1] }, material = \"rubber\" }]\n[materials.rubber]\n"),
      HasSubstr("body.0: 'water' is a fluid and 'rubber' is not"));
  EXPECT_THAT(with("[domain]\nlow = [0, 0, 0]\nhigh = [1, 0, 1]\n"),
              HasSubstr("s.toml:14:8: domain.high[1] = 0 must be above"));
  EXPECT_THAT(with("[domain]\nlow = [0, 0, 0]\nhigh = [0.5, 1, 1]\nperiodic = [true, false, false]\n"),
              HasSubstr("domain repeats along x after 0.5 m"));
  EXPECT_THAT(with("[domain]\nlow = [0, 0, 0]\nhigh = [1, 1, 1]\nperiodic = [true, 2, false]\n"),
              HasSubstr("domain.periodic[1] must be true or false"));
  EXPECT_THAT(with("[domain]\nlow = [0, 0, 0]\n"), HasSubstr("domain lacks 'high'"));
  EXPECT_THAT(complaint(small_scene + "[domain]\nlow = [0, 0, 0]\nhigh = [1, 1, 1]\n"),
              HasSubstr("only fluids have one"));
  EXPECT_THAT(complaint(small_scene + "[fluid]\nhorizon = 2.1\n"),
              HasSubstr("no body of a material with model"));
  EXPECT_THAT(with("[fluid]\ndensity_iterations = 0\n"), HasSubstr("density_iterations = 0 is out of range"));
  EXPECT_THAT(with("[solver]\nintegrator = \"bdf2\"\n"), HasSubstr("fluids have none to choose"));
  EXPECT_THAT(with("[output]\nfields = [\"strain\"]\n"),
              HasSubstr("output.fields: fluids have no \"strain\""));
  EXPECT_THAT(with("[render]\ncolor = \"energy\"\n"), HasSubstr("fluids have no such field"));
}

const std::string clay = "[simulation]\n"
                         "spacing = 0.1\n"
                         "[materials.clay]\n"
                         "model = \"viscoelastic\"\n"
                         "young = 2e5\n"
                         "poisson = 0.25\n"
                         "plastic = { cohesion = 1e3, friction = 10 }\n"
                         "relaxation_time = 0.5\n"
                         "viscosity = 2\n"
                         "[[body]]\n"
                         "name = \"lump\"\n"
                         "material = \"clay\"\n"
                         "shape = { box = [1, 1, 1] }\n";

TEST(ViscoelasticScene, KeysAreRead) {
  const Scene scene =
      parsed(clay + "[output]\nfields = [\"plastic_strain\"]\n[render]\ncolor = \"plastic_strain\"\n");
  const Material& material = scene.materials[0];
  ASSERT_TRUE(scene.flows());
  EXPECT_TRUE(material.fluid());
  EXPECT_TRUE(material.bonded());
  EXPECT_EQ(material.young, 2e5);
  EXPECT_EQ(material.poisson, 0.25);
  EXPECT_TRUE(material.plastic.given);
  EXPECT_EQ(material.plastic.cohesion, 1e3);
  EXPECT_EQ(material.relaxation_time, 0.5);
  EXPECT_EQ(material.viscosity, 2);
  const nlohmann::json json = scene_to_json(scene)["materials"]["clay"];
  EXPECT_EQ(json["model"], "viscoelastic");
  EXPECT_EQ(json["young"], 2e5);
  EXPECT_EQ(json["relaxation_time"], 0.5);
  EXPECT_EQ(json["plastic"]["cohesion"], 1e3);
  EXPECT_FALSE(json.contains("law"));
  EXPECT_FALSE(scene_to_json(parsed(water))["materials"]["water"].contains("relaxation_time"));
}

TEST(ViscoelasticScene, WrongOnesAreRefused) {
  const auto with = [](const std::string& was, const std::string& now) {
    std::string text = clay;
    return complaint(text.replace(text.find(was), was.size(), now));
  };
  EXPECT_EQ(complaint(clay), "");
  EXPECT_THAT(with("young = 2e5", "young = -1"),
              HasSubstr("s.toml:5:9: materials.clay.young = -1 is out of range"));
  EXPECT_THAT(with("poisson = 0.25", "poisson = 0.5"),
              HasSubstr("s.toml:6:11: materials.clay.poisson = 0.5 must be at most 0.499"));
  EXPECT_THAT(with("poisson = 0.25", "poisson = -0.1"),
              HasSubstr("materials.clay.poisson = -0.1 is out of range"));
  EXPECT_THAT(with("cohesion = 1e3", "cohesion = -1"), HasSubstr("cohesion = -1 is out of range"));
  EXPECT_THAT(with("friction = 10", "friction = 90"), HasSubstr("friction = 90 is out of range"));
  EXPECT_THAT(with("cohesion = 1e3, friction = 10", "cohesion = 0"),
              HasSubstr("materials.clay.plastic.cohesion = 0 without friction bears nothing"));
  EXPECT_THAT(with("relaxation_time = 0.5", "relaxation_time = 0"),
              HasSubstr("s.toml:8:19: materials.clay.relaxation_time = 0 is out of range"));
  EXPECT_THAT(with("young = 2e5", "law = \"ordinary\""),
              HasSubstr("s.toml:5:1: materials.clay.law is one of elastic materials"));
  EXPECT_THAT(with("viscosity = 2", "fracture_energy = 2"),
              HasSubstr("materials.clay.fracture_energy is one of elastic"));
  EXPECT_THAT(with("\"viscoelastic\"", "\"jelly\""), HasSubstr("viscoelastic"));
  std::string text = water;
  EXPECT_THAT(
      complaint(text.replace(text.find("viscosity = 0.5"), 15, "relaxation_time = 1")),
      HasSubstr("s.toml:5:1: materials.water.relaxation_time applies to model = \"viscoelastic\" only"));
  EXPECT_THAT(complaint(with_line(4, "relaxation_time = 1")),
              HasSubstr("materials.rubber.relaxation_time applies to model = \"viscoelastic\" only"));
  EXPECT_THAT(complaint(clay + "[output]\nfields = [\"strain\"]\n"), HasSubstr("fluids have no \"strain\""));
  EXPECT_THAT(complaint(water + "[output]\nfields = [\"plastic_strain\"]\n"), HasSubstr("plastic"));
  EXPECT_THAT(complaint(clay + "[[body]]\nmaterial = \"steel\"\nshape = { sphere = 1 }\n[materials.steel]\n"),
              HasSubstr("is elastic and another is a fluid"));
}

// Walls may meet in a corner; one within another is one too many.
TEST(FluidScene, OverlappingGhostsAreRefused) {
  const auto refused = [](const std::string& second, const std::string& condition = "no-slip") {
    const Scene scene =
        parsed(water +
               "[domain]\nlow = [-1, -1, -1]\nhigh = [1, 1, 1]\n"
               "[[boundary]]\nname = \"floor\"\nshape = { plane = [0, 1, 0], offset = -0.6 }\n"
               "condition = \"no-slip\"\n[[boundary]]\nname = \"second\"\nshape = " +
               second + "\ncondition = \"" + condition + "\"\n");
    try {
      sample_ghosts(scene, assemble(scene));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string message = "s.toml:21:9: boundary 'second': all of it lies in boundary 'floor'";
  EXPECT_EQ(refused("{ plane = [1, 0, 0], offset = -0.6 }"), "");
  EXPECT_EQ(refused("{ box = [0.4, 0.4, 0.4], at = [0, -0.6, 0] }"), "");
  EXPECT_THAT(refused("{ box = [0.4, 0.2, 0.4], at = [0, -0.75, 0] }"), HasSubstr(message));
  EXPECT_THAT(refused("{ plane = [0, 1, 0], offset = -0.63 }"), HasSubstr("all of it lies in boundary"));
  EXPECT_THAT(refused("{ plane = [0, 1, 0], offset = -0.6 }"), HasSubstr("all of it lies in boundary"));
  EXPECT_EQ(refused("{ plane = [0, 1, 0], offset = -0.6 }", "slip"), "");
}

} // namespace
} // namespace pliant
