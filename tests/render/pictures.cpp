// What a picture shows, pixel by pixel: place, light, shadow, edges, fields, boundaries.
#include "stage.h"

#include "backends/gl/gl_device.h"
#include "backends/gl/render/camera.h"
#include "backends/gl/render/creases.h"
#include "backends/gl/render/palette.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace pliant::test {
namespace {

using gl::arrange;
using gl::Stage;

Stage stage_of(const Show& show) {
  return arrange(show.scene, gl::outline_at_start(show.model), {});
}

std::array<int, 3> pixel_at(const Show& show, const Image& image, const Vector3& world) {
  const Vector3 at = stage_of(show).view.project(world, image.width, image.height);
  EXPECT_TRUE(at.x() >= 0 && at.y() >= 0 && at.x() < image.width && at.y() < image.height) << at.transpose();
  return pixel(image, at.x(), at.y());
}

Show ball_on_floor() {
  Show show;
  show.add_body(ball({0, 0.5, 0}, 0.5, 0.1), {0.85, 0.2, 0.15});
  show.add_floor();
  show.upload();
  return show;
}

Show globe_on_floor(std::unique_ptr<Device> device = openmp::make_device(Precision::double_precision, 1)) {
  Show show(std::move(device));
  show.add_body(ball({0, 0.5, 0}, 0.5, 0.1), {0.85, 0.2, 0.15}).surface = globe({0, 0.5, 0}, 0.5);
  show.add_floor();
  show.upload();
  return show;
}

bool red(const std::array<int, 3>& p) {
  return p[0] > 1.5 * p[1] && p[0] > 1.5 * p[2];
}

void expect_body_and_shadow(const Show& show, const Image& image) {
  ASSERT_EQ(image.width, 320u);
  ASSERT_EQ(image.height, 240u);
  ASSERT_EQ(image.channels, 3u);
  const Stage stage = stage_of(show);
  EXPECT_TRUE(red(pixel_at(show, image, {0, 0.5, 0})));
  for (const double side : {-0.4, 0.4})
    EXPECT_TRUE(red(pixel_at(show, image, Vector3(0, 0.5, 0) + side * stage.view.right)));
  for (const double side : {-0.75, 0.75})
    EXPECT_FALSE(red(pixel_at(show, image, Vector3(0, 0.5, 0) + side * stage.view.right)));

  // On the floor: in the far half of the shadow, which the ball does not hide, and on the sunny side.
  const Vector3 sun = stage.to_sun;
  Vector3 away = -Vector3(sun.x(), 0, sun.z());
  const double reach = 0.5 / sun.y() * away.norm();
  away.normalize();
  const Vector3 dark = (reach + 0.45) * away, lit = -(reach + 0.3) * away;
  const auto shadowed = pixel_at(show, image, dark), sunny = pixel_at(show, image, lit);
  EXPECT_FALSE(red(shadowed));
  EXPECT_FALSE(red(sunny));
  EXPECT_LT(brightness(shadowed), 0.75 * brightness(sunny));
}

TEST(Picture, ParticlesStandWhereTheProjectionSaysAndCastAShadow) {
  const Show show = ball_on_floor();
  const Image image = show.renderer()->draw(*show.device, show.state());
  keep(image, "test-particles");
  expect_body_and_shadow(show, image);
}

TEST(Picture, MeshStandsWhereTheProjectionSaysAndCastsAShadow) {
  const Show show = globe_on_floor();
  const Image image = show.renderer()->draw(*show.device, show.state());
  keep(image, "test-mesh");
  expect_body_and_shadow(show, image);
}

TEST(Picture, TheSimulationsOwnBuffersGiveTheSamePicture) {
  if (!gl::describe_all().front().usable) GTEST_SKIP() << "no GL device";
  const Show copied = globe_on_floor(), shared = globe_on_floor(gl::make_device(0));
  const Image a = copied.renderer()->draw(*copied.device, copied.state());
  const Image b = shared.renderer()->draw(*shared.device, shared.state());
  EXPECT_EQ(a.pixels, b.pixels);
}

TEST(Picture, IsTheSameTwice) {
  const Show show = ball_on_floor();
  const auto renderer = show.renderer();
  const Image first = renderer->draw(*show.device, show.state());
  EXPECT_EQ(first.pixels, renderer->draw(*show.device, show.state()).pixels);
  EXPECT_EQ(first.pixels, show.renderer()->draw(*show.device, show.state()).pixels);
}

// Along a row through the middle of a pale globe before a dark floor, the pixels at an edge lie in between.
unsigned between_at_edges(unsigned samples, const std::string& shown) {
  Show show = globe_on_floor();
  show.scene.render.samples = samples;
  show.scene.render.show = shown;
  const Image image = show.renderer()->draw(*show.device, show.state());
  keep(image, "test-edge-" + shown + std::to_string(samples));
  const auto redness = [](const std::array<int, 3>& p) { return (p[0] - p[1]) / double(p[0] + 1); };
  unsigned between = 0;
  for (unsigned y = 1; y < image.height; ++y)
    for (unsigned x = 1; x + 1 < image.width; ++x) {
      const double left = redness(pixel(image, x - 1, y)), here = redness(pixel(image, x, y)),
                   right = redness(pixel(image, x + 1, y));
      const double low = std::min(left, right), high = std::max(left, right);
      if (low < 0.1 && high > 0.55 && here > low + 0.12 && here < high - 0.12) ++between;
    }
  return between;
}

TEST(Picture, EdgesAreSmooth) {
  for (const char* shown : {"surface", "particles"}) {
    const unsigned hard = between_at_edges(1, shown), soft = between_at_edges(4, shown),
                   softer = between_at_edges(8, shown);
    std::printf("%s: pixels between, at 1, 4 and 8 samples: %u %u %u\n", shown, hard, soft, softer);
    EXPECT_LT(4 * hard, soft);
    EXPECT_GT(soft, 60u);
    EXPECT_GT(softer, 60u);
  }
}

TEST(Picture, FieldColoursRiseWithTheField) {
  Show show;
  const std::vector<Vector3> points = ball({0, 0.6, 0}, 0.5, 0.1);
  std::vector<double> field;
  for (const Vector3& p : points) field.push_back(p.y());
  show.add_body(points, {0.85, 0.2, 0.15});
  show.add_floor();
  show.scene.render.color = "displacement";
  show.upload(field);
  const Image image = show.renderer("displacement, m")->draw(*show.device, show.state());
  keep(image, "test-field");
  // From violet to yellow: green rises against blue all the way up.
  const Stage stage = stage_of(show);
  double before = -1e9;
  for (const double height : {0.22, 0.42, 0.62, 0.82, 1.02}) {
    const double reach = std::sqrt(std::max(0.0, 0.25 - (height - 0.6) * (height - 0.6)));
    const Vector3 front = Vector3(0, height, 0) -
                          reach * Vector3(stage.view.forward.x(), 0, stage.view.forward.z()).normalized();
    const auto p = pixel_at(show, image, front);
    const double green = (p[1] - p[2]) / double(p[1] + p[2] + 1);
    EXPECT_GT(green, before) << height;
    before = green;
  }
  EXPECT_GT(before, 0.2);

  // The legend: low colour below high colour in one column near the right side.
  const Colour low = gl::field_colours()[4], high = gl::field_colours()[251];
  const auto find = [&](const Colour& c) {
    for (unsigned y = 0; y < image.height; ++y)
      for (unsigned x = image.width * 2 / 3; x < image.width; ++x)
        if (const auto p = pixel(image, x, y);
            std::abs(p[0] - c[0]) + std::abs(p[1] - c[1]) + std::abs(p[2] - c[2]) < 8)
          return std::pair<int, int>(int(x), int(y));
    return std::pair<int, int>(-1, -1);
  };
  const auto at_low = find(low), at_high = find(high);
  ASSERT_GE(at_low.first, 0);
  ASSERT_GE(at_high.first, 0);
  EXPECT_EQ(at_low.first, at_high.first);
  EXPECT_GT(at_low.second, at_high.second + 100);

  // A range given scales the colours: all values above it are of the highest colour.
  show.scene.render.range = {-2.0, -1.0};
  const Image clipped = show.renderer()->draw(*show.device, show.state());
  const auto top = pixel_at(show, clipped, {0, 0.6, 0});
  EXPECT_GT(top[0], top[2] + 30);
  EXPECT_GT(top[1], top[2] + 30);
}

TEST(Picture, MovingBoundaryMoves) {
  Show show;
  show.add_body(ball({0, 0.3, 0}, 0.3, 0.1), {0.85, 0.2, 0.15});
  show.add_floor();
  Boundary box;
  box.shape.kind = Shape::Kind::box;
  box.shape.at = {-0.6, 0.2, 0.2};
  box.shape.size = {0.2, 0.4, 0.2};
  box.motion.velocity = {0, 0.2, 0};
  box.motion.end = 2;
  show.scene.boundaries.push_back(box);
  show.upload();
  gl::Box around;
  around.add(Vector3(-0.7, 0, 0.1));
  around.add(Vector3(-0.5, 0.4, 0.3));
  const Stage stage = arrange(show.scene, gl::outline_at_start(show.model), {around});
  const auto renderer = show.renderer();
  const Image start = renderer->draw(*show.device, show.state(0)),
              later = renderer->draw(*show.device, show.state(2)),
              after = renderer->draw(*show.device, show.state(3));
  keep(start, "test-boundary0");
  keep(later, "test-boundary2");
  EXPECT_NE(start.pixels, later.pixels);
  EXPECT_EQ(later.pixels, after.pixels); // its motion has ended
  // Released, it is drawn to its end, and then as if it had never been.
  show.scene.boundaries.back().motion.release = true;
  const auto releasing = show.renderer();
  const Image to_the_end = releasing->draw(*show.device, show.state(2)),
              gone = releasing->draw(*show.device, show.state(2.01));
  keep(gone, "test-boundary-gone");
  EXPECT_EQ(to_the_end.pixels, later.pixels);
  const Vector3 inside = stage.view.project({-0.6, 0.55, 0.3}, 320, 240);
  EXPECT_NE(pixel(gone, inside.x(), inside.y()), pixel(later, inside.x(), inside.y()));
  EXPECT_EQ(pixel(gone, inside.x(), inside.y()), pixel(start, inside.x(), inside.y()));
  // A side of the box is coloured otherwise than the floor that is seen once it has gone, and the other way
  // round.
  for (const auto& [y, first, second] :
       {std::tuple(0.15, &start, &later), std::tuple(0.55, &later, &start)}) {
    const Vector3 at = stage.view.project({-0.6, y, 0.3}, 320, 240);
    const auto with = pixel(*first, at.x(), at.y()), without = pixel(*second, at.x(), at.y());
    EXPECT_GT(
        std::abs(with[0] - without[0]) + std::abs(with[1] - without[1]) + std::abs(with[2] - without[2]), 20)
        << y;
  }
}

TEST(Picture, TooLargeIsRefused) {
  Show show = ball_on_floor();
  show.scene.render.size = {1000000, 10};
  try {
    show.renderer();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    EXPECT_NE(std::string(error.what()).find("render.size"), std::string::npos) << error.what();
  }
}

TEST(Picture, ParticlesWithoutNumbersDoNotSpoilIt) {
  Show show = ball_on_floor();
  std::vector<Real4<double>> values = show.device->download_real4(show.particle);
  values[3] = {NAN, NAN, NAN, NAN};
  values[7].x = INFINITY;
  show.device->upload(show.particle, std::span<const Real4<double>>(values));
  expect_body_and_shadow(show, show.renderer()->draw(*show.device, show.state()));
}

TEST(Camera, FramesTheBodies) {
  for (const std::array<unsigned, 2> size : {std::array<unsigned, 2>{1280, 720}, {480, 640}}) {
    Show show;
    show.scene.render.size = size;
    show.add_body(ball({3, 2.5, -1}, 0.5, 0.05), {1, 0, 0});
    show.add_floor(1.0);
    const Stage stage = stage_of(show);
    gl::Box seen;
    for (const Vector3& p : show.model.position)
      for (const double drop : {0.0, 1.0}) {
        const Vector3 at = stage.view.project(p - Vector3(0, drop, 0), size[0], size[1]);
        seen.add(Vector3(at.x() / size[0], at.y() / size[1], 0));
      }
    const double fill = std::max(seen.high.x() - seen.low.x(), seen.high.y() - seen.low.y());
    EXPECT_GT(fill, 0.60);
    EXPECT_LT(fill, 0.75);
    EXPECT_NEAR(seen.low.x() + seen.high.x(), 1, 0.05);
    EXPECT_NEAR(seen.low.y() + seen.high.y(), 1, 0.05);
    EXPECT_NEAR(stage.view.right.dot(stage.up), 0, 1e-12); // the horizon is level
    EXPECT_GT(stage.view.up.dot(stage.up), 0.8);
    EXPECT_GT(stage.to_sun.dot(stage.up), 0.5);
  }
}

TEST(Camera, UpIsAgainstGravityAndTheScenesCameraIsTaken) {
  Show show;
  show.add_body(ball({0, 0, 0}, 0.5, 0.1), {1, 0, 0});
  show.scene.simulation.gravity = {0, 0, -9.81};
  EXPECT_NEAR(stage_of(show).up.z(), 1, 1e-12);
  EXPECT_GT(stage_of(show).view.up.z(), 0.8);
  ASSERT_TRUE(stage_of(show).ground.has_value());
  EXPECT_NEAR((*stage_of(show).ground)[3], -0.55, 1e-9); // half a spacing below the lowest particle
  show.scene.render.camera = Camera{{0, -5, 0}, {0, 0, 0}, {0, 0, 1}, 60};
  const Vector3 at = stage_of(show).view.project({0, 0, 5 * std::tan(30 * 3.14159265358979 / 180)}, 320, 240);
  EXPECT_NEAR(at.x(), 160, 1e-9);
  EXPECT_NEAR(at.y(), 0, 1e-9);
  EXPECT_NEAR(at.z(), 5, 1e-12);
}

TEST(Camera, MotionTurnsAboutItsAxisAndEnds) {
  Motion motion;
  motion.about = {1, 0, 0};
  motion.axis = {0, 0, 1};
  motion.rate = 3.14159265358979323846 / 2;
  motion.velocity = {0, 0, 2};
  motion.start = 1;
  motion.end = 2;
  const auto moved = [&](double time) {
    const Eigen::Matrix4d m = gl::motion_matrix(motion, time);
    return Vector3(m.topLeftCorner<3, 3>() * Vector3(2, 0, 0) + m.topRightCorner<3, 1>());
  };
  EXPECT_LT((moved(0.5) - Vector3(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((moved(2) - Vector3(1, 1, 2)).norm(), 1e-12);
  EXPECT_LT((moved(9) - Vector3(1, 1, 2)).norm(), 1e-12);
}

TEST(Creases, ABoxKeepsItsEdgesAndAGlobeIsSmooth) {
  Mesh box;
  for (int i = 0; i < 8; ++i) box.vertices.emplace_back(i & 1, (i >> 1) & 1, i >> 2);
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const gl::DrawnMesh drawn = gl::split_creases(box);
  EXPECT_EQ(drawn.corners.size(), 24u); // three sides at each of eight corners
  for (std::size_t t = 0; t < box.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(drawn.corners[drawn.indices[t][c]][0], box.triangles[t][c]);
  const Mesh ball = globe({0, 0, 0}, 1);
  EXPECT_EQ(gl::split_creases(ball).corners.size(), ball.vertices.size());
}

TEST(Palette, LightnessRisesEvenly) {
  std::set<Colour> different;
  double before = -1;
  for (const Colour& c : gl::field_colours()) {
    const double light = 0.2126 * gl::to_linear(c[0] / 255.0) + 0.7152 * gl::to_linear(c[1] / 255.0) +
                         0.0722 * gl::to_linear(c[2] / 255.0);
    const double lightness = 116 * (light > 0.008856 ? std::cbrt(light) : 7.787 * light + 16.0 / 116) - 16;
    EXPECT_GT(lightness, before - 0.15);
    if (before >= 0) {
      EXPECT_NEAR(lightness - before, 75.0 / 255, 0.45); // rounding to 8 bits
    }
    before = lightness;
    different.insert(c);
  }
  EXPECT_GT(different.size(), 250u);
}

} // namespace
} // namespace pliant::test
