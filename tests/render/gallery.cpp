// Larger pictures, for people to look at, with the time they take: only where PLIANT_TEST_PICTURES names a
// folder.
#include "stage.h"

#include "backends/gl/gl_device.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>

namespace pliant::test {
namespace {

class Gallery : public testing::Test {
protected:
  void SetUp() override {
    if (!std::getenv("PLIANT_TEST_PICTURES"))
      GTEST_SKIP() << "set PLIANT_TEST_PICTURES to a folder to see pictures";
    show.scene.render.size = {1280, 720};
  }
  void draw(const std::string& name, const std::string& label = "") {
    const auto renderer = show.renderer(label);
    renderer->draw(*show.device, show.state());
    const std::clock_t before = std::clock();
    const auto start = std::chrono::steady_clock::now();
    const Image image = renderer->draw(*show.device, show.state(0.5));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    const double work = double(std::clock() - before) / CLOCKS_PER_SEC;
    std::printf("%s: %zu particles, %.3f s, of all processors %.3f s\n", name.c_str(), show.model.count(),
                took.count(), work);
    keep(image, name);
  }
  Show show{gl::make_device(0)};
};

Mesh placed(const std::string& name, double size, const Vector3& foot, double turn) {
  const char* home = std::getenv("HOME");
  Mesh mesh = read_mesh(std::filesystem::path(home ? home : "") / ".cache/pliant/meshes" / name);
  Vector3 low = mesh.vertices[0], high = low;
  for (Vector3& v : mesh.vertices) {
    v = Vector3(std::cos(turn) * v.x() + std::sin(turn) * v.z(), v.y(),
                -std::sin(turn) * v.x() + std::cos(turn) * v.z());
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double scale = size / (high - low).maxCoeff();
  for (Vector3& v : mesh.vertices)
    v = foot + scale * (v - Vector3(0.5 * (low.x() + high.x()), low.y(), 0.5 * (low.z() + high.z())));
  return mesh;
}

TEST_F(Gallery, ParticlesOfABall) {
  show.model.spacing = 0.055;
  show.add_body(ball({0, 1.05, 0}, 1.0, 0.055), {0.80, 0.42, 0.28});
  show.add_floor();
  show.upload();
  draw("ball");
}

TEST_F(Gallery, Field) {
  show.model.spacing = 0.08;
  std::vector<double> field;
  for (const Vector3& p : ball({0, 1, 0}, 1.0, 0.08)) field.push_back(p.y() * 12);
  show.add_body(ball({0, 1, 0}, 1.0, 0.08), {0.80, 0.42, 0.28});
  show.add_floor();
  show.scene.render.color = "velocity";
  show.upload(field);
  draw("field", "speed, m/s");
}

TEST_F(Gallery, MeshesOnTheFloor) {
  try {
    show.add_body({}, {0.80, 0.42, 0.28}).surface = placed("armadillo.off", 1.0, {-0.4, 0, 0}, 3.14159);
    show.add_body({}, {0.24, 0.52, 0.62}).surface = placed("bunny00.off", 0.7, {0.55, 0.0, 0.1}, 0);
  } catch (const Error& error) {
    GTEST_SKIP() << error.what();
  }
  for (const BodyModel& body : show.model.bodies)
    for (const Vector3& v : body.surface->vertices) show.model.position.push_back(v);
  show.add_floor();
  show.upload();
  draw("meshes");
}

TEST_F(Gallery, FallingMeshAndBoundaries) {
  show.add_body(ball({0, 1.2, 0}, 0.3, 0.05), {0.86, 0.66, 0.30});
  show.model.spacing = 0.05;
  Boundary box;
  box.shape.kind = Shape::Kind::box;
  box.shape.size = {0.6, 0.4, 0.6};
  box.shape.at = {0.1, 0.2, 0};
  box.shape.rotate_degrees = 20;
  show.scene.boundaries.push_back(box);
  box.shape.kind = Shape::Kind::torus;
  box.shape.radius = 0.25;
  box.shape.tube = 0.08;
  box.shape.at = {-0.7, 0.3, 0.1};
  box.shape.rotate_axis = {1, 0, 0};
  box.shape.rotate_degrees = 70;
  show.scene.boundaries.push_back(box);
  box.shape.kind = Shape::Kind::cylinder;
  box.shape.radius = 0.15;
  box.shape.height = 0.5;
  box.shape.at = {0.9, 0.25, 0.2};
  box.shape.rotate_degrees = 0;
  show.scene.boundaries.push_back(box);
  show.add_floor();
  show.upload();
  draw("boundaries");
}

} // namespace
} // namespace pliant::test
