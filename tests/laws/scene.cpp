// Scene files with laws over basis functions: what is read, written to run.json, and refused, with its place.
#include "engine/core/error.h"
#include "engine/scene/scene_json.h"
#include "engine/scene/scene_parse.h"
#include "tests/laws/materials.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

using testing::HasSubstr;

constexpr const char* scene_text = R"(format = 1
[simulation]
spacing = 0.1
[[body]]
material = "m"
shape = { box = [0.5, 0.5, 0.5] }
[materials.m]
)";

Scene parse(const std::string& material) {
  return parse_scene(scene_text + material, "scene.toml");
}

std::string refusal(const std::string& material) {
  try {
    parse(material);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  return "";
}

TEST(StretchScene, IsReadAndWritten) {
  const Scene scene = parse(R"(law = "basis"
basis = { g = { A2 = 1 }, h = { A4 = 0.5, B1 = "1/2" } }
calibration = "xu2018"
anisotropy = { strengths = [4, 0.25, 1], rotate = { axis = [0, 0, 2], degrees = 90 } })");
  const Material& m = scene.materials[0];
  EXPECT_EQ(m.bond_basis, (Shares{{"A4", 0.5}, {"B1", 0.5}}));
  EXPECT_TRUE(m.anisotropy.given);
  EXPECT_EQ(m.anisotropy.rotate_axis, Vector3(0, 0, 1));
  const auto written = scene_to_json(scene)["materials"]["m"];
  EXPECT_EQ(written["basis"]["h"]["A4"], 0.5);
  EXPECT_EQ(written["calibration"], "xu2018");
  EXPECT_EQ(written["anisotropy"]["strengths"][0], 4);
  EXPECT_FALSE(written.contains("form"));
  const Scene stvk = parse("law = \"stvk\"");
  EXPECT_EQ(scene_to_json(stvk)["materials"]["m"]["form"], "exact");
  EXPECT_TRUE(stretch_energy(stvk.materials[0]).squared);
  EXPECT_FALSE(stretch_energy(parse("law = \"stvk\"\nform = \"bonds\"").materials[0]).squared);
  EXPECT_EQ(law_of(parse("law = \"neo-hookean\"\nform = \"bonds\"").materials[0]), Law::basis);
  const auto plain = scene_to_json(parse("law = \"corotated\""))["materials"]["m"];
  for (const char* key : {"form", "basis", "calibration", "anisotropy"})
    EXPECT_FALSE(plain.contains(key)) << key;
}

TEST(StretchScene, AssemblesWithAWarningOfWhatXu2018Gives) {
  const Model model = assemble(parse(R"(law = "basis"
basis = { g = { A1 = 1 }, h = { A1 = 1 } }
calibration = "xu2018"
young = 1e5
poisson = 0.25)"));
  ASSERT_FALSE(model.warnings.empty());
  EXPECT_THAT(model.warnings[0], HasSubstr("106667 Pa"));
  EXPECT_THAT(model.warnings[0], HasSubstr("0.3333"));
}

TEST(StretchScene, BadOnesAreRefusedWithTheirPlace) {
  const std::string law = "law = \"basis\"\n", good = "basis = { g = { A2 = 1 }, h = { B1 = 1 } }\n";
  EXPECT_EQ(refusal(law + good), "");
  EXPECT_THAT(refusal(law), HasSubstr("materials.m lacks 'basis'"));
  EXPECT_THAT(refusal(law + "basis = { g = { A2 = 1 } }"), HasSubstr("h"));
  const std::string negative = refusal(law + "basis = { g = { A2 = 1 }, h = { B3 = 1.5, B1 = -0.5 } }");
  EXPECT_THAT(negative, HasSubstr("scene.toml:9:31: materials.m.basis.h: the share of B1 is -0.5"));
  EXPECT_THAT(negative, HasSubstr("above 0.58 only"));
  EXPECT_THAT(refusal(law + "basis = { g = { A2 = 1 }, h = { C3 = 1 } }"),
              HasSubstr("A1 to A8 and B1 to B8"));
  EXPECT_THAT(refusal(law + "basis = { g = { A2 = 1 }, h = { B9 = 1 } }"), HasSubstr("higher power"));
  EXPECT_THAT(refusal(law + "basis = { g = { A2 = 1 }, h = { B1 = 1, B2 = 1, B3 = 1, B4 = 1, B5 = 1 } }"),
              HasSubstr("more than the 4"));
  EXPECT_THAT(refusal(law + "basis = { g = { A2 = 1 }, h = { B1 = \"x\" } }"), HasSubstr("must be a number"));
  EXPECT_THAT(refusal(law + "basis = { g = 3, h = { B1 = 1 } }"), HasSubstr("table of numbers"));
  EXPECT_THAT(refusal(law + good + "poisson = 0.1"), HasSubstr("not convex"));
  EXPECT_THAT(refusal("law = \"corotated\"\n" + good), HasSubstr("applies to law = \"basis\" only"));
  EXPECT_THAT(refusal("law = \"corotated\"\nform = \"bonds\""), HasSubstr("materials.m.form applies to"));
  EXPECT_THAT(refusal("law = \"ordinary\"\ncalibration = \"xu2018\""), HasSubstr("calibration applies to"));
  EXPECT_THAT(refusal("law = \"corotated\"\nanisotropy = { strengths = [1, 2, 3] }"),
              HasSubstr("anisotropy applies to"));
  const std::string directed = law + good + "anisotropy = { strengths = [1, 2, 3]";
  EXPECT_EQ(refusal(directed + " }"), "");
  EXPECT_THAT(refusal(law + good + "anisotropy = { strengths = [1, 0, 3] }"), HasSubstr("above 0"));
  EXPECT_THAT(refusal(law + good + "anisotropy = { strengths = [1, -2, 3] }"),
              HasSubstr("strengths[1] = -2"));
  EXPECT_THAT(refusal(directed + ", directions = [[1, 0, 0], [0.1, 1, 0], [0, 0, 1]] }"),
              HasSubstr("directions"));
  EXPECT_THAT(refusal(directed + ", directions = [[1, 0, 0], [0.6, 0.8, 0], [0, 0, 1]] }"),
              HasSubstr("right angles"));
  EXPECT_THAT(
      refusal(directed + ", around = { axis = [0, 1, 0] }, rotate = { axis = [0, 1, 0], degrees = 3 } }"),
      HasSubstr("leave one out"));
}

TEST(StretchScene, MoreMaterialsThanKernelsHold) {
  Scene scene = parse("law = \"stvk\"");
  const auto device = open_double();
  for (int k = 1; k < 16; ++k) {
    scene.materials.push_back(scene.materials[0]);
    scene.materials.back().name += std::to_string(k);
  }
  const Model fitting = assemble(scene);
  EXPECT_NO_THROW(Simulation(*device, scene, fitting));
  scene.materials.push_back(scene.materials[0]);
  scene.materials.back().name = "one too many";
  const Model model = assemble(scene);
  EXPECT_THROW(Simulation(*device, scene, model), Error);
}

} // namespace
} // namespace pliant::test
