// Scene files that are right: values, units, defaults, fractions, every shape and condition, overrides.
#include "parse.h"

#include "engine/scene/scene_json.h"
#include "engine/scene/scene_new.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <numbers>

namespace pliant {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(SceneParse, SmallSceneGetsDefaults) {
  const Scene scene = parsed(small_scene);
  EXPECT_EQ(scene.name, "s");
  EXPECT_EQ(scene.simulation.spacing, 0.1);
  EXPECT_EQ(scene.simulation.horizon, 1.87);
  EXPECT_EQ(scene.solver.method, "auto");
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].name, "rubber");
  EXPECT_EQ(scene.materials[0].law, "corotated");
  EXPECT_FALSE(scene.materials[0].color_given);
  ASSERT_EQ(scene.bodies.size(), 1u);
  EXPECT_EQ(scene.bodies[0].shape.kind, Shape::Kind::sphere);
  EXPECT_EQ(scene.bodies[0].shape.radius, 0.5);
  EXPECT_FALSE(scene.render.given);
}

TEST(SceneParse, EveryTableIsRead) {
  const Scene scene = parsed(R"(
format = 1
name = "full"
allow = ["sparse"]
[simulation]
spacing = "1/50"
time_step = "1/30"
end = 3
gravity = [0, 0, -1]
[solver]
method = "jacobi"
iterations = 1e3
integrator = "bdf2"
spectral_radius = 0.5
[contact]
self = true
[materials.a]
law = "projective"
split = 0.25
color = [1, 0, 0]
[materials.b]
poisson = 0
[[body]]
name = "x"
material = "a"
shape = { torus = { ring = 0.5, tube = 0.1 }, at = [1, 2, 3], rotate = { axis = [0, 0, 2], degrees = 90 } }
deform = [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
start = "flat"
self_contact = false
[[body.fixed]]
region = { plane = [0, 3, 0], at = [0, 2, 0] }
[[body.moved]]
region = { cylinder = { radius = 1, height = 2 } }
velocity = [1, 0, 0]
rotation = { axis = [0, 5, 0], about = [1, 1, 1], rate_degrees = 180 }
start = 0.5
end = 2
release = true
[[body.loaded]]
region = { box = [1, 2, 3] }
force = [0, 1, 0]
end = 1
[[body.region]]
region = { sphere = 1, at = [0, 1, 0] }
material = "b"
[[body.deformed]]
region = { plane = [1, 0, 0], offset = 0.5 }
deform = [[-0.5, 0, 0.25], [0, 1, 0], [0, 0, 1]]
about = [0.5, 0, 0]
[[body.deformed]]
region = { sphere = 1 }
deform = [[1, 0, 0], [0, 2, 0], [0, 0, 1]]
[[body]]
material = "b"
shape = { mesh = "m.off", fit = 2 }
[[boundary]]
shape = { plane = [0, 2, 0], offset = -1 }
condition = "no-slip"
[[boundary]]
name = "ball"
shape = { sphere = 1 }
friction = 0.5
inside = true
velocity = [0, 1, 0]
end = 2
release = true
visible = false
[output]
fps = 24
fields = ["strain", "velocity", "strain"]
data = false
[render]
size = [640, 480]
camera = { eye = [1, 1, 1], look = [0, 0, 0], up = [0, 0, 4], fov = 50 }
color = "strain"
range = [0, 0.5]
samples = 1
)");
  EXPECT_FALSE(scene.allow_overlap);
  EXPECT_TRUE(scene.allow_sparse);
  EXPECT_DOUBLE_EQ(scene.simulation.spacing, 0.02);
  EXPECT_DOUBLE_EQ(scene.simulation.time_step, 1.0 / 30);
  EXPECT_EQ(scene.simulation.gravity, Vector3(0, 0, -1));
  EXPECT_EQ(scene.solver.iterations, 1000u);
  EXPECT_EQ(scene.solver.integrator, "bdf2");
  EXPECT_EQ(scene.solver.spectral_radius, 0.5);
  EXPECT_TRUE(scene.contact.self);
  EXPECT_EQ(scene.materials[0].poisson, 0.25); // the only ratio that the law has
  EXPECT_EQ(scene.materials[0].split, 0.25);
  EXPECT_TRUE(scene.materials[0].color_given);
  EXPECT_EQ(scene.materials[1].poisson, 0);

  const Body& x = scene.bodies[0];
  EXPECT_EQ(x.shape.kind, Shape::Kind::torus);
  EXPECT_EQ(x.shape.radius, 0.5);
  EXPECT_EQ(x.shape.tube, 0.1);
  EXPECT_EQ(x.shape.at, Vector3(1, 2, 3));
  EXPECT_EQ(x.shape.rotate_axis, Vector3(0, 0, 1));
  EXPECT_EQ(x.shape.rotate_degrees, 90);
  EXPECT_EQ(x.deform(0, 1), 2); // rows as typed
  EXPECT_EQ(x.deform(2, 0), 7);
  EXPECT_EQ(x.start, "flat");
  EXPECT_FALSE(x.self_contact);
  ASSERT_EQ(x.conditions.size(), 3u);
  EXPECT_EQ(x.conditions[0].kind, Condition::Kind::fixed);
  EXPECT_EQ(x.conditions[0].region.normal, Vector3(0, 1, 0));
  EXPECT_EQ(x.conditions[0].region.offset, 2); // a plane through `at`
  const Condition& moved = x.conditions[1];
  EXPECT_EQ(moved.kind, Condition::Kind::moved);
  EXPECT_EQ(moved.region.height, 2);
  EXPECT_EQ(moved.motion.velocity, Vector3(1, 0, 0));
  EXPECT_EQ(moved.motion.axis, Vector3(0, 1, 0));
  EXPECT_EQ(moved.motion.about, Vector3(1, 1, 1));
  EXPECT_NEAR(moved.motion.rate, std::numbers::pi, 1e-15);
  EXPECT_EQ(moved.motion.start, 0.5);
  EXPECT_EQ(moved.motion.end, 2);
  EXPECT_EQ(moved.motion.release, true);
  EXPECT_EQ(x.conditions[2].force, Vector3(0, 1, 0));
  EXPECT_EQ(x.conditions[2].end, 1);
  ASSERT_EQ(x.regions.size(), 1u);
  EXPECT_EQ(x.regions[0].material, "b");

  ASSERT_EQ(x.deformed.size(), 2u);
  EXPECT_EQ(x.deformed[0].region.offset, 0.5);
  EXPECT_EQ(x.deformed[0].deform(0, 2), 0.25);
  EXPECT_EQ(x.deformed[0].about, Vector3(0.5, 0, 0));
  EXPECT_EQ(x.deformed[1].deform(1, 1), 2);
  EXPECT_FALSE(x.deformed[1].about.has_value());

  EXPECT_EQ(scene.bodies[1].name, "body-1");
  EXPECT_EQ(scene.bodies[1].shape.mesh, "m.off");
  EXPECT_EQ(scene.bodies[1].shape.fit, 2);
  EXPECT_FALSE(scene.bodies[1].shape.place.has_value());
  EXPECT_EQ(scene.boundaries[0].shape.offset, -1);
  EXPECT_FALSE(scene.boundaries[0].slip);
  EXPECT_TRUE(scene.boundaries[1].slip);
  EXPECT_TRUE(scene.boundaries[1].inside);
  EXPECT_FALSE(scene.boundaries[1].visible);
  EXPECT_EQ(scene.boundaries[1].motion.end, 2);
  EXPECT_EQ(scene.boundaries[1].motion.release, true);
  EXPECT_FALSE(scene.boundaries[0].motion.release.has_value());
  EXPECT_THAT(scene.output.fields, ElementsAre("strain", "velocity"));
  EXPECT_FALSE(scene.output.data);
  EXPECT_TRUE(scene.render.given);
  EXPECT_THAT(scene.render.size, ElementsAre(640u, 480u));
  ASSERT_TRUE(scene.render.camera.has_value());
  EXPECT_EQ(scene.render.camera->up, Vector3(0, 0, 1));
  EXPECT_EQ(scene.render.camera->fov, 50);
  EXPECT_EQ((*scene.render.range)[1], 0.5);

  const nlohmann::json json = scene_to_json(scene);
  EXPECT_EQ(json["simulation"]["time_step"], 1.0 / 30);
  EXPECT_EQ(json["simulation"]["horizon"], 1.87); // a default
  EXPECT_EQ(json["allow"], nlohmann::json({"sparse"}));
  EXPECT_EQ(json["materials"]["a"]["split"], 0.25);
  EXPECT_FALSE(json["materials"]["b"].contains("split"));
  EXPECT_EQ(json["body"][0]["shape"]["torus"]["tube"], 0.1);
  EXPECT_FALSE(json["body"][0]["shape"].contains("box"));
  EXPECT_NEAR(json["body"][0]["moved"][0]["rotation"]["rate_degrees"].get<double>(), 180, 1e-12);
  EXPECT_EQ(json["body"][0]["deform"][1][2], 6);
  EXPECT_EQ(json["body"][0]["deformed"][0]["deform"][0][0], -0.5);
  EXPECT_TRUE(json["body"][0]["deformed"][1]["about"].is_null()); // their centre of mass
  EXPECT_FALSE(json["body"][1]["shape"].contains("at"));
  EXPECT_EQ(json["boundary"][0]["condition"], "no-slip");
  EXPECT_TRUE(json["boundary"][0]["end"].is_null()); // never
  EXPECT_EQ(json["boundary"][1]["release"], true);
  EXPECT_EQ(json["render"]["camera"]["fov"], 50);
  EXPECT_TRUE(scene_to_json(parsed(small_scene))["render"]["camera"].is_null());
}

TEST(SceneParse, MaterialsKeepTheirOrder) {
  const Scene scene =
      parsed("[materials.z]\n[materials.a]\n[materials.m]\n[simulation]\nspacing=1\n[[body]]\n"
             "material=\"a\"\nshape={box=[1,1,1]}\n");
  EXPECT_EQ(scene.materials[0].name, "z");
  EXPECT_EQ(scene.materials[1].name, "a");
  EXPECT_EQ(scene.materials[2].name, "m");
}

TEST(SceneOverride, TakesTomlWordsAndFractions) {
  const Scene scene =
      parsed(small_scene, {"solver.tolerance=1e-4", "simulation.time_step=\"1/60\"", "simulation.end = 1/4",
                           "materials.rubber.young=1e6", "body.0.velocity=[0,-1,0]", "body.ball.start=flat",
                           "solver.integrator=bdf2", "body.ball.shape.sphere=0.25", "allow=[\"overlap\"]",
                           "body.ball.fixed=[{region={box=[1,1,1]}}]", "body.ball.fixed.0.region.at=[0,1,0]",
                           "render.camera={eye=[1,1,1],look=[0,0,0]}", "name=other", "contact.self=true"});
  EXPECT_EQ(scene.solver.tolerance, 1e-4);
  EXPECT_DOUBLE_EQ(scene.simulation.time_step, 1.0 / 60);
  EXPECT_EQ(scene.simulation.end, 0.25);
  EXPECT_EQ(scene.materials[0].young, 1e6);
  EXPECT_EQ(scene.bodies[0].velocity, Vector3(0, -1, 0));
  EXPECT_EQ(scene.bodies[0].start, "flat");
  EXPECT_EQ(scene.solver.integrator, "bdf2");
  EXPECT_EQ(scene.bodies[0].shape.radius, 0.25);
  EXPECT_TRUE(scene.allow_overlap);
  ASSERT_EQ(scene.bodies[0].conditions.size(), 1u);
  EXPECT_EQ(scene.bodies[0].conditions[0].region.at, Vector3(0, 1, 0));
  EXPECT_TRUE(scene.render.given && scene.render.camera);
  EXPECT_EQ(scene.name, "other");
  EXPECT_TRUE(scene.contact.self);
}

TEST(SceneOverride, QuotesKeepDotsAndLaterOnesWin) {
  const Scene scene = parsed("[materials.\"a.b\"]\n[simulation]\nspacing=1\n[[body]]\nmaterial=\"a.b\"\n"
                             "shape={box=[1,1,1]}\n",
                             {"materials.\"a.b\".young=5", "materials.'a.b'.young=7"});
  EXPECT_EQ(scene.materials[0].young, 7);
}

TEST(SceneOverride, FaultsNameTheOverrideAndTheNearestKey) {
  EXPECT_EQ(complaint(small_scene, {"solver.tolerence=1"}),
            "--set solver.tolerence=1: unknown key 'tolerence' in 'solver'; did you mean 'tolerance'?");
  EXPECT_THAT(complaint(small_scene, {"solvr.tolerance=1"}), HasSubstr("did you mean 'solver'?"));
  EXPECT_THAT(complaint(small_scene, {"materials.ruber.young=1"}), HasSubstr("did you mean 'rubber'?"));
  EXPECT_THAT(complaint(small_scene, {"body.1.velocity=[0,0,0]"}),
              HasSubstr("no '1' in 'body'; there are 0 ('ball')"));
  EXPECT_THAT(complaint(small_scene, {"boundary.floor.friction=1"}), HasSubstr("the scene has none"));
  EXPECT_THAT(
      complaint(small_scene, {"solver.tolerance=2"}),
      HasSubstr("--set solver.tolerance=2: solver.tolerance = 2 is out of range: it must be 1e-12 to 1"));
  EXPECT_THAT(complaint(small_scene, {"solver.tolerance"}), HasSubstr("key=value"));
  EXPECT_THAT(complaint(small_scene, {"solver..tolerance=1"}), HasSubstr("key=value"));
  EXPECT_THAT(complaint(small_scene, {"body.0.velocity=[1,"}), HasSubstr("not valid TOML"));
  EXPECT_THAT(complaint(small_scene, {"solver.tolerance=1\nmethod=2"}), HasSubstr("more than one value"));
  EXPECT_THAT(complaint(small_scene, {"solver.tolerance.x=1"}), HasSubstr("has no 'x' within"));
  EXPECT_THAT(complaint(small_scene, {"solver="}), HasSubstr("not valid TOML"));
}

TEST(SceneExamples, AllParse) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PLIANT_SOURCE_DIR "/examples")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().string());
    ++count;
    EXPECT_NO_THROW({
      const Scene scene = read_scene(entry.path());
      EXPECT_EQ(scene.name, entry.path().stem().string());
      EXPECT_FALSE(scene.description.empty());
    });
  }
  EXPECT_GE(count, 5u);
}

TEST(SceneExamples, BeamTakesItsThreeSteps) {
  for (const double step : {0.001, 0.004, 0.016}) {
    const Scene scene =
        read_scene(PLIANT_SOURCE_DIR "/examples/beam.toml", {"simulation.time_step=" + std::to_string(step)});
    EXPECT_DOUBLE_EQ(scene.simulation.time_step, step);
    const double steps = 1 / (scene.output.fps * step);
    EXPECT_NEAR(steps, std::round(steps), 1e-9); // so the steps are not shortened
  }
}

TEST(SceneNew, EveryKindParses) {
  for (const auto& [kind, meaning] : new_scene_kinds()) {
    EXPECT_FALSE(meaning.empty());
    EXPECT_EQ(parsed(new_scene_text(kind)).name, kind);
  }
  EXPECT_THROW(
      {
        try {
          new_scene_text("bean");
        } catch (const Error& error) {
          EXPECT_THAT(error.what(), HasSubstr("did you mean 'beam'?"));
          throw;
        }
      },
      Error);
}

TEST(SceneFile, MissingOrFolder) {
  EXPECT_THROW(read_scene("/nonexistent/scene.toml"), Error);
  EXPECT_THROW(read_scene(PLIANT_SOURCE_DIR), Error);
}

} // namespace
} // namespace pliant
