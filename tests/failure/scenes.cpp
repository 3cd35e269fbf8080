// What a scene may say of failure: what it comes to, and what is refused with its place.
#include "engine/model/failure.h"
#include "engine/scene/scene_json.h"
#include "tests/program/program.h"
#include "tests/scene/parse.h"

#include <nlohmann/json.hpp>

#include <limits>
#include <numbers>

namespace pliant {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(FailureScenes, KeysThatAreWrong) {
  EXPECT_THAT(complaint(with_line(4, "critical_stretch = -0.1")),
              AllOf(StartsWith("s.toml:4:20:"), HasSubstr("materials.rubber.critical_stretch"),
                    HasSubstr("bonds at rest have a stretch of 1 and must not break")));
  EXPECT_THAT(complaint(with_line(4, "critical_stretch = 0")), StartsWith("s.toml:4:20:"));
  EXPECT_THAT(complaint(with_line(4, "fracture_energy = 0")),
              AllOf(StartsWith("s.toml:4:19:"), HasSubstr("a crack that takes no energy")));
  EXPECT_THAT(complaint(with_line(4, "fracture_energy = -3")), StartsWith("s.toml:4:19:"));
  EXPECT_THAT(complaint(with_line(4, "fracture_energy = nan")), StartsWith("s.toml:4:19:"));
  EXPECT_THAT(complaint(with_line(4, "fracture_energy = \"much\"")), StartsWith("s.toml:4:19:"));
  EXPECT_THAT(complaint(with_line(4, "fracture_energy = 3\ncritical_stretch = 0.1")),
              AllOf(StartsWith("s.toml:5:1:"), HasSubstr("keep one")));
}

TEST(FailureScenes, LawsThatCannotBreak) {
  for (const char* law : {"projective", "neo-hookean"})
    EXPECT_THAT(complaint(with_line(4, std::string("law = \"") + law + "\"\nfracture_energy = 3")),
                AllOf(StartsWith("s.toml:5:1:"), HasSubstr("do not break"), HasSubstr("choose law")))
        << law;
  EXPECT_EQ(complaint(with_line(4, "law = \"neo-hookean\"\nform = \"bonds\"\nfracture_energy = 3")), "");
  EXPECT_THAT(complaint(with_line(4, "law = \"ordinary\"\ninversion = \"clamp\"\nfracture_energy = 3")),
              AllOf(StartsWith("s.toml:5:13:"), HasSubstr("leave it out, or fracture_energy")));
}

TEST(FailureScenes, DamageWhereNothingBreaks) {
  EXPECT_THAT(complaint(small_scene + "[output]\nfields = [\"damage\"]\n"),
              AllOf(StartsWith("s.toml:10:10:"), HasSubstr("no damage where nothing breaks")));
  EXPECT_THAT(complaint(small_scene + "[render]\ncolor = \"damage\"\n"),
              AllOf(StartsWith("s.toml:10:9:"), HasSubstr("no damage where nothing breaks")));
  EXPECT_EQ(complaint(with_line(4, "critical_stretch = 0.1") + "[render]\ncolor = \"damage\"\n"), "");
}

// A cut is a box that parts particles; one that parts none is a mistake.
TEST(FailureScenes, CutsThatSeverNothing) {
  const auto says = [](const std::string& cut) {
    const Scene scene = parsed(small_scene + "[[body.cut]]\nregion = { " + cut + " }\n");
    try {
      assemble(scene);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(says("box = [0.5, 0.001, 2], at = [0.2, 0, 0]"), "");
  EXPECT_THAT(says("box = [0.5, 0.001, 2], at = [3, 0, 0]"),
              AllOf(StartsWith("s.toml:8:9: body 'ball'"), HasSubstr("cut 1 severs no bond"),
                    HasSubstr("between particles of the body")));
  EXPECT_THAT(says("sphere = 0.2"), HasSubstr("a cut is a box"));
}

// The program says so with exit code 2.
TEST(FailureScenes, ExitCodeIsTwo) {
  const test::Folder folder;
  for (const char* line : {"critical_stretch = -1", "fracture_energy = 0"}) {
    const test::Outcome outcome = test::pliant(folder, {"check", folder.write("s.toml", with_line(4, line))});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("s.toml:4:"));
  }
}

TEST(FailureScenes, AreWrittenToTheRecord) {
  const Scene scene = parsed(with_line(4, "fracture_energy = 135") +
                             "[[body.cut]]\nregion = { box = [0.5, 0.001, 2], at = [0.2, 0, 0] }\n");
  EXPECT_EQ(scene.materials[0].fracture_energy, 135);
  const nlohmann::json record = scene_to_json(scene);
  EXPECT_EQ(record["materials"]["rubber"]["fracture_energy"], 135);
  EXPECT_EQ(record["body"][0]["cut"].size(), 1u);
  EXPECT_TRUE(scene_to_json(parsed(small_scene))["materials"]["rubber"]["fracture_energy"].is_null());
}

TEST(FailureScenes, NothingBreaksUnlessAsked) {
  const Scene scene = parsed(small_scene);
  const Model model = assemble(scene);
  EXPECT_FALSE(can_break(scene, model));
  for (const double stretch : critical_stretches(scene, model))
    EXPECT_EQ(stretch, std::numeric_limits<double>::infinity());
}

} // namespace
} // namespace pliant
