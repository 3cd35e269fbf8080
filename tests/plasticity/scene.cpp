// Scene files with materials that flow: what is read, written to run.json, and refused, with its place.
#include "engine/core/error.h"
#include "engine/io/statistics_writer.h"
#include "engine/model/plasticity.h"
#include "engine/scene/scene_json.h"
#include "engine/scene/scene_parse.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace pliant::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Lines 1 to 6; the material's keys from 7.
constexpr const char* scene_text = R"([simulation]
spacing = 0.1
[[body]]
material = "clay"
shape = { box = [0.5, 0.5, 0.5] }
[materials.clay]
)";

Scene parse(const std::string& material, std::string text = scene_text) {
  return parse_scene(text + material, "scene.toml");
}
std::string refusal(const std::string& material, const std::string& text = scene_text) {
  try {
    parse(material, text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  return "";
}

TEST(PlasticScene, IsReadAndWritten) {
  const Scene scene = parse("plastic = { cohesion = 1e4, friction = 30, hardening = 500 }");
  const Material& m = scene.materials[0];
  EXPECT_TRUE(m.plastic.given);
  EXPECT_EQ(m.plastic.cohesion, 1e4);
  EXPECT_NEAR(m.plastic.friction, std::acos(-1.0) / 6, 1e-15);
  EXPECT_EQ(m.law, "ordinary");
  const auto written = scene_to_json(scene)["materials"]["clay"];
  EXPECT_EQ(written["law"], "ordinary");
  EXPECT_NEAR(written["plastic"]["friction"].get<double>(), 30, 1e-12);
  EXPECT_EQ(written["plastic"]["hardening"], 500);
  const Scene plain = parse("young = 1e5");
  EXPECT_FALSE(plain.materials[0].plastic.given);
  EXPECT_EQ(plain.materials[0].law, "corotated");
  EXPECT_FALSE(scene_to_json(plain)["materials"]["clay"].contains("plastic"));
  EXPECT_EQ(parse("plastic = { cohesion = 0, friction = 35 }\nlaw = \"ordinary\"").materials[0].law,
            "ordinary");
  parse("plastic = { cohesion = 1 }\n[output]\nfields = [\"plastic_strain\"]");
}

TEST(PlasticScene, RefusesWithThePlace) {
  EXPECT_THAT(refusal("plastic = { cohesion = 1e4, friction = 90 }"),
              AllOf(HasSubstr("scene.toml:7:40"), HasSubstr("at least 0 and below 90")));
  EXPECT_THAT(refusal("plastic = { cohesion = 1e4, friction = -1 }"), HasSubstr("scene.toml:7:40"));
  EXPECT_THAT(refusal("plastic = { cohesion = -1 }"),
              AllOf(HasSubstr("scene.toml:7:24"), HasSubstr("at least 0")));
  EXPECT_THAT(refusal("plastic = { cohesion = 1, hardening = -1 }"), HasSubstr("scene.toml:7:39"));
  EXPECT_THAT(refusal("plastic = { friction = 30 }"),
              AllOf(HasSubstr("scene.toml:7:"), HasSubstr("cohesion")));
  EXPECT_THAT(refusal("plastic = { cohesion = 0 }"),
              AllOf(HasSubstr("scene.toml:7:24"), HasSubstr("bears nothing")));
  EXPECT_THAT(refusal("plastic = { cohesion = 1, angle = 3 }"), HasSubstr("scene.toml:7:27"));
  EXPECT_THAT(refusal("plastic = 3"), HasSubstr("scene.toml:7:"));
  for (const char* law : {"corotated", "projective", "basis", "stvk", "neo-hookean"})
    EXPECT_THAT(refusal(std::string("law = \"") + law + "\"\nplastic = { cohesion = 1 }"),
                AllOf(HasSubstr("scene.toml:7:7"), HasSubstr("does not flow")));
  EXPECT_THAT(refusal("plastic = { cohesion = 1 }\ncritical_stretch = 0.1"),
              AllOf(HasSubstr("scene.toml:8:1"), HasSubstr("flow and break")));
  EXPECT_THAT(refusal("young = 1e5\n[output]\nfields = [\"plastic_strain\"]"),
              AllOf(HasSubstr("scene.toml:9:10"), HasSubstr("no plastic strain")));
  const std::string sheet = "[simulation]\nspacing = 0.1\n[[body]]\nmaterial = \"clay\"\n"
                            "shape = { sheet = [0.5, 0.5] }\nthickness = 0.01\n[materials.clay]\n";
  EXPECT_THAT(refusal("plastic = { cohesion = 1 }", sheet),
              AllOf(HasSubstr("scene.toml:4:12"), HasSubstr("a sheet")));
  const std::string stress = "[simulation]\nspacing = 0.1\ndimension = 2\nplane = \"stress\"\n"
                             "gravity = [0, -9.81, 0]\n[[body]]\nmaterial = \"clay\"\n"
                             "shape = { box = [0.5, 0.5, 0.5] }\n[materials.clay]\n";
  EXPECT_THAT(refusal("plastic = { cohesion = 1 }", stress),
              AllOf(HasSubstr("scene.toml:7:12"), HasSubstr("plane stress")));
}

TEST(PlasticScene, LibraryUsersAreRefusedToo) {
  Material clay;
  clay.law = "ordinary";
  const auto refused = [&](double cohesion, double friction, double hardening, Neighbourhood n) {
    clay.plastic = {true, cohesion, friction, hardening};
    EXPECT_THROW(yield_surface(clay, n), Error);
  };
  refused(-1, 0.5, 0, Neighbourhood::solid);
  refused(1, 1.6, 0, Neighbourhood::solid);
  refused(1, -0.1, 0, Neighbourhood::solid);
  refused(1, 0.5, -1, Neighbourhood::solid);
  refused(0, 0, 0, Neighbourhood::solid);
  refused(1, 0.5, 0, Neighbourhood::plane_stress);
  Scene scene = parse("plastic = { cohesion = 1 }");
  const Model model = assemble(scene);
  EXPECT_TRUE(can_flow(scene, model));
  EXPECT_EQ(yield_surfaces(scene, model).size(), model.count());
  scene.materials[0].law = "corotated";
  EXPECT_THROW(yield_surfaces(scene, model), Error);
  scene.materials[0].law = "ordinary";
  scene.materials[0].critical_stretch = 0.1;
  EXPECT_THROW(yield_surfaces(scene, model), Error);
}

// The columns of a scene that flows come last, with or without those of one whose bonds break.
TEST(PlasticScene, ColumnsAreReadBack) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("pliant-plastic-" + std::to_string(::getpid()) + ".csv");
  for (const bool breaks : {false, true})
    for (const bool flows : {false, true}) {
      std::vector<std::string> components{"motion"};
      if (breaks) components.emplace_back("failure");
      if (flows) components.emplace_back("plasticity");
      StatisticsRow row;
      row.step = 3, row.time = 0.25, row.stopped = "floor";
      row.ms_components.assign(components.size(), 0.5);
      if (breaks) row.fracture = {7, 0.1};
      if (flows) row.plastic = {12, 1.0 / 3, 0.02, -1e-9, 3, 1e-4};
      StatisticsWriter(path, components, false).append(row);
      const std::vector<StatisticsRow> rows = read_statistics(path);
      ASSERT_EQ(rows.size(), 1u);
      EXPECT_EQ(rows[0].plastic, row.plastic);
      EXPECT_EQ(rows[0].fracture, row.fracture);
      EXPECT_EQ(rows[0].ms_components, row.ms_components);
    }
  std::filesystem::remove(path);
}

} // namespace
} // namespace pliant::test
