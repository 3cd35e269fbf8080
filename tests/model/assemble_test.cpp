// Scenes into particles: materials, conditions, initial states, order, and the errors people will meet.
#include "engine/core/error.h"
#include "tests/model/lattice.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace pliant {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Shape box(const Vector3& at, const Vector3& size) {
  Shape shape;
  shape.kind = Shape::Kind::box;
  shape.at = at;
  shape.size = size;
  return shape;
}

Body body(const std::string& name, const std::string& material, const Shape& shape) {
  Body made;
  made.name = name;
  made.material = material;
  made.shape = shape;
  return made;
}

/// One box of 8 x 6 x 5 particles.
Scene box_scene() {
  Scene scene;
  scene.name = "test";
  scene.file = "folder/test.toml";
  scene.simulation.spacing = 0.1;
  scene.materials = {test::material("corotated", 1e5, 0.3), test::material("ordinary", 2e5, 0.2)};
  scene.materials[0].name = "rubber";
  scene.materials[1].name = "wood";
  scene.materials[1].density = 500;
  scene.bodies = {body("brick", "rubber", box({1, 2, 3}, {0.8, 0.6, 0.5}))};
  return scene;
}

std::string refusal(const Scene& scene) {
  try {
    assemble(scene);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  return "nothing thrown";
}

Vector3 centre(const Model& model, const std::vector<Vector3>& of) {
  Vector3 sum = Vector3::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < model.count(); ++i) {
    sum += model.mass[i] * of[i];
    mass += model.mass[i];
  }
  return sum / mass;
}

TEST(Assemble, FillsABoxAndSharesItsVolume) {
  const Model model = assemble(box_scene());
  ASSERT_EQ(model.count(), 240u);
  EXPECT_EQ(model.components, 1u);
  ASSERT_EQ(model.laws.size(), 1u);
  EXPECT_EQ(model.laws[0].count, 240u);
  double volume = 0, mass = 0;
  for (std::size_t i = 0; i < model.count(); ++i) {
    volume += model.volume[i];
    mass += model.mass[i];
    EXPECT_LT((model.bodies[0].origin + model.bodies[0].axes * model.reference[i] - model.position[i]).norm(),
              1e-12);
  }
  EXPECT_NEAR(volume, 0.24, 1e-12);
  EXPECT_NEAR(mass, 240, 1e-9);
  EXPECT_LT((centre(model, model.position) - Vector3(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT(model.weight_report.worst_residual, 1e-13);
  EXPECT_EQ(model.weight_report.signatures, 27u);
  ASSERT_TRUE(model.bodies[0].surface);
  ASSERT_EQ(model.bodies[0].surface_reference.size(), model.bodies[0].surface->vertices.size());
  for (std::size_t v = 0; v < model.bodies[0].surface_reference.size(); ++v)
    EXPECT_LT((model.bodies[0].origin + model.bodies[0].axes * model.bodies[0].surface_reference[v] -
               model.bodies[0].surface->vertices[v])
                  .norm(),
              1e-12);
}

TEST(Assemble, OrdersByLawThenBodyAndNumbersThroughTheScene) {
  Scene scene = box_scene();
  scene.bodies = {body("log", "wood", box({0, 0, 0}, {0.4, 0.4, 0.4})),
                  body("brick", "rubber", box({2, 0, 0}, {0.3, 0.3, 0.3})),
                  body("plank", "wood", box({4, 0, 0}, {0.5, 0.3, 0.3}))};
  const Model model = assemble(scene);
  ASSERT_EQ(model.count(), 64u + 27 + 45);
  ASSERT_EQ(model.laws.size(), 2u);
  EXPECT_EQ(model.laws[0].law, Law::corotated);
  EXPECT_EQ(model.laws[0].count, 27u);
  EXPECT_EQ(model.laws[1].first, 27u);
  EXPECT_EQ(model.laws[1].first_slice, 2u);
  EXPECT_EQ(model.bodies[0].first, 27u);
  EXPECT_EQ(model.bodies[1].first, 0u);
  EXPECT_EQ(model.bodies[2].first, 27u + 64);
  std::set<std::uint32_t> ids(model.id.begin(), model.id.end());
  EXPECT_EQ(ids.size(), model.count());
  EXPECT_EQ(*ids.rbegin(), model.count() - 1);
  for (std::size_t i = 0; i < model.count(); ++i) {
    const std::uint32_t b = model.body[i];
    EXPECT_EQ(model.id[i] < 64 ? 0u : model.id[i] < 91 ? 1u : 2u, b);
    EXPECT_EQ(model.material[i], b == 1 ? 0u : 1u);
    for (std::uint32_t k = model.bonds.begin[i]; k < model.bonds.begin[i + 1]; ++k) {
      EXPECT_EQ(model.body[model.bonds.neighbour[k]], b);
      EXPECT_EQ(model.bonds.neighbour[model.bonds.reverse[k]], i);
    }
  }
  EXPECT_EQ(model.components, 3u);
  const SlicedBonds sliced = slice_bonds(model);
  EXPECT_EQ(sliced.slice_begin.size(), 2u + 7 + 1);
}

TEST(Assemble, RegionsGiveMaterialsAndTheLaterWins) {
  Scene scene = box_scene();
  scene.materials[1].law = "corotated";
  scene.bodies[0].regions = {{box({1, 2, 3}, {0.8, 0.6, 0.5}), "rubber"},
                             {box({1.3, 2, 3}, {0.4, 2, 2}), "wood"}};
  const Model model = assemble(scene);
  std::size_t wooden = 0;
  for (std::size_t i = 0; i < model.count(); ++i) {
    wooden += model.material[i];
    EXPECT_EQ(model.material[i], model.position[i].x() > 1.1 ? 1u : 0u);
    EXPECT_NEAR(model.mass[i], model.material[i] ? 0.5 : 1.0, 1e-12);
  }
  EXPECT_EQ(wooden, 90u);
}

TEST(Assemble, ConditionsHoldMoveAndLoad) {
  Scene scene = box_scene();
  Condition held, moved, loaded;
  held.region = box({0.6, 2, 3}, {0.2, 2, 2});
  moved.kind = Condition::Kind::moved;
  moved.region = box({1.4, 2, 3}, {0.2, 2, 2});
  moved.motion.velocity = {0.5, 0, 0};
  loaded.kind = Condition::Kind::loaded;
  loaded.region = box({1, 2.3, 3}, {2, 0.2, 2});
  loaded.force = {0, -12, 3};
  loaded.start = 1;
  scene.bodies[0].conditions = {held, moved, loaded};
  const Model model = assemble(scene);
  ASSERT_EQ(model.motions.size(), 2u);
  EXPECT_EQ(model.motions[0].velocity, Vector3::Zero());
  EXPECT_EQ(model.motions[1].velocity, Vector3(0.5, 0, 0));
  EXPECT_EQ(model.held.size(), 60u);
  for (const Held& h : model.held) EXPECT_EQ(h.motion, model.position[h.particle].x() < 1 ? 0u : 1u);
  EXPECT_EQ(model.loads.size(), 40u);
  Vector3 total = Vector3::Zero();
  for (const Load& load : model.loads) {
    total += load.force;
    EXPECT_EQ(load.start, 1);
    EXPECT_GT(model.position[load.particle].y(), 2.2);
  }
  EXPECT_LT((total - Vector3(0, -12, 3)).norm(), 1e-12);
}

TEST(Assemble, VelocityAndSpinAreAboutTheCentreOfMass) {
  Scene scene = box_scene();
  scene.bodies[0].velocity = {1, 2, 3};
  scene.bodies[0].spin = {0, 0, 2};
  const Model model = assemble(scene);
  EXPECT_LT((centre(model, model.velocity) - Vector3(1, 2, 3)).norm(), 1e-12);
  for (std::size_t i = 0; i < model.count(); ++i) {
    const Vector3 r = model.position[i] - Vector3(1, 2, 3);
    EXPECT_LT((model.velocity[i] - Vector3(1 - 2 * r.y(), 2 + 2 * r.x(), 3)).norm(), 1e-12);
  }
}

TEST(Assemble, DeformAndStartMovePositionsOnly) {
  const Model rest = assemble(box_scene());
  const Vector3 c(1, 2, 3);
  const auto from = [](const std::string& start, const Matrix3& deform) {
    Scene scene = box_scene();
    scene.bodies[0].start = start;
    scene.bodies[0].deform = deform;
    return assemble(scene);
  };
  Matrix3 shear = Matrix3::Identity();
  shear(0, 1) = 0.5;
  const struct {
    const char* start;
    Matrix3 deform, expected;
  } cases[] = {{"", shear, shear},
               {"flat", Matrix3::Identity(), Vector3(0, 1, 1).asDiagonal()},
               {"line", Matrix3::Identity(), Vector3(0, 1, 0).asDiagonal()},
               {"point", Matrix3::Identity(), Matrix3::Zero()},
               {"mirror", Matrix3::Identity(), Vector3(-1, 1, 1).asDiagonal()}};
  for (const auto& one : cases) {
    const Model model = from(one.start, one.deform);
    EXPECT_EQ(model.reference, rest.reference);
    EXPECT_EQ(model.bonds.weight, rest.bonds.weight);
    for (std::size_t i = 0; i < model.count(); ++i)
      EXPECT_LT((model.position[i] - (c + one.expected * (rest.position[i] - c))).norm(), 1e-12) << one.start;
  }
  const Model random = from("random", Matrix3::Identity()), again = from("random", Matrix3::Identity());
  EXPECT_EQ(random.position, again.position);
  double spread = 0;
  for (std::size_t i = 0; i < random.count(); ++i) {
    const Vector3 r = random.position[i] - c;
    EXPECT_LE(r.cwiseAbs().x(), 0.35 + 1e-12);
    EXPECT_LE(r.cwiseAbs().y(), 0.25 + 1e-12);
    EXPECT_LE(r.cwiseAbs().z(), 0.2 + 1e-12);
    spread += r.x() * r.x() / static_cast<double>(random.count());
  }
  EXPECT_NEAR(spread, 0.7 * 0.7 / 12, 0.15 * 0.7 * 0.7 / 12); // uniform: width^2 / 12
}

// Parts go by rest positions, one after the other; the whole's own deformation comes last.
TEST(Assemble, DeformedRegionsMoveTheirParticlesOnly) {
  const Model rest = assemble(box_scene());
  const Vector3 c(1, 2, 3);
  DeformedRegion right; // folded over the plane x = 1, and shortened
  right.region.kind = Shape::Kind::plane;
  right.region.normal = {-1, 0, 0};
  right.region.offset = -c.x();
  right.deform = Vector3(-0.6, 1, 1).asDiagonal();
  right.about = c;
  DeformedRegion top = right; // about its own centre
  top.region.normal = {0, -1, 0};
  top.region.offset = -c.y();
  top.deform = Vector3(2, 1, 1).asDiagonal();
  top.about.reset();
  const auto from = [](const std::vector<DeformedRegion>& deformed, double stretch) {
    Scene scene = box_scene();
    scene.bodies[0].deformed = deformed;
    scene.bodies[0].deform(1, 1) = stretch;
    return assemble(scene);
  };
  const Model folded = from({right}, 3), both = from({right, top}, 1);
  EXPECT_EQ(folded.reference, rest.reference);
  EXPECT_EQ(folded.bonds.weight, rest.bonds.weight);
  const auto folded_x = [&](const Vector3& r) { return r.x() > 0 ? -0.6 * r.x() : r.x(); };
  double centre_of_top = 0, count = 0;
  for (const Vector3& p : rest.position)
    if (p.y() > c.y()) centre_of_top += folded_x(p - c), count += 1;
  centre_of_top /= count;
  for (std::size_t i = 0; i < rest.count(); ++i) {
    const Vector3 r = rest.position[i] - c;
    const double x = folded_x(r);
    EXPECT_LT((folded.position[i] - c - Vector3(x, 3 * r.y(), r.z())).norm(), 1e-12);
    const double stretched = r.y() > 0 ? 2 * x - centre_of_top : x;
    EXPECT_LT((both.position[i] - c - Vector3(stretched, r.y(), r.z())).norm(), 1e-12);
  }
  right.region.offset = -20;
  Scene scene = box_scene();
  scene.bodies[0].deformed = {top, right};
  EXPECT_THAT(refusal(scene),
              AllOf(HasSubstr("'brick'"), HasSubstr("deformed region 2 selects no particle")));
}

TEST(Assemble, RefusesOverlapUnlessAllowed) {
  Scene scene = box_scene();
  scene.bodies.push_back(body("stone", "rubber", box({1.6, 2, 3}, {0.8, 0.6, 0.5})));
  EXPECT_THAT(refusal(scene),
              AllOf(HasSubstr("test.toml"), HasSubstr("'brick'"), HasSubstr("'stone'"), HasSubstr("0.2 m")));
  scene.allow_overlap = true;
  const Model model = assemble(scene);
  EXPECT_EQ(model.count(), 480u);
  EXPECT_THAT(model.warnings, testing::Contains(HasSubstr("overlap")));
  // Side by side, a spacing apart: no overlap. Collapsed to a point in a distant corner: no quadratic search.
  scene.allow_overlap = false;
  scene.bodies[1].shape.at.x() = 1.8;
  EXPECT_EQ(refusal(scene), "nothing thrown");
  scene.bodies[1].start = "point";
  EXPECT_EQ(refusal(scene), "nothing thrown");
}

TEST(Assemble, RefusesSparseBodiesWithASpacingThatWouldDo) {
  Scene scene = box_scene();
  scene.bodies[0] = body("twig", "rubber", box({0, 0, 0}, {2, 0.1, 0.1}));
  const std::string text = refusal(scene);
  EXPECT_THAT(text, AllOf(HasSubstr("test.toml: body 'twig' has 20 of 20 particles"), HasSubstr("would do")));
  const auto at = text.find("a spacing of ", text.find(';'));
  ASSERT_NE(at, std::string::npos) << text;
  Scene finer = scene;
  finer.simulation.spacing = std::stod(text.substr(at + 13));
  EXPECT_LT(finer.simulation.spacing, 0.1);
  EXPECT_EQ(refusal(finer), "nothing thrown");
  scene.allow_sparse = true;
  EXPECT_THAT(assemble(scene).warnings, testing::Contains(HasSubstr("20 of 20")));
  scene.allow_sparse = false;
  scene.bodies[0] = body("crumb", "rubber", box({0, 0, 0}, {0.2, 0.2, 0.1}));
  EXPECT_THAT(refusal(scene), AllOf(HasSubstr("'crumb' has 4 particles"), HasSubstr("would do")));
}

TEST(Assemble, NamesWhatIsWrong) {
  Scene scene = box_scene();
  Condition nowhere;
  nowhere.region = box({9, 9, 9}, {1, 1, 1});
  scene.bodies[0].conditions = {nowhere};
  EXPECT_THAT(refusal(scene),
              AllOf(HasSubstr("'brick'"), HasSubstr("condition 1 (fixed) selects no particle"),
                    HasSubstr("(0.65, 1.75, 2.8)"), HasSubstr("(1.35, 2.25, 3.2)")));
  scene = box_scene();
  scene.bodies[0].regions = {{box({9, 9, 9}, {1, 1, 1}), "rubber"}};
  EXPECT_THAT(refusal(scene), HasSubstr("region 1 (material 'rubber') selects no particle"));
  scene = box_scene();
  scene.bodies[0].regions = {{box({1, 2, 3}, {1, 1, 1}), "wood"}};
  EXPECT_THAT(refusal(scene), HasSubstr("must share one"));
  scene = box_scene();
  scene.bodies[0].material = "cheese";
  EXPECT_THAT(refusal(scene), HasSubstr("no material 'cheese'"));
  scene = box_scene();
  scene.materials[0].poisson = 0.5;
  EXPECT_THAT(refusal(scene), AllOf(HasSubstr("material 'rubber'"), HasSubstr("0.499")));
}

} // namespace
} // namespace pliant
