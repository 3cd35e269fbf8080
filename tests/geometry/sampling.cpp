// Shapes filled with particles, and how far points are from shapes.
#include "tests/geometry/meshes.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>

namespace pliant::test {
namespace {

using testing::HasSubstr;

Shape shape_of(Shape::Kind kind) {
  Shape shape;
  shape.kind = kind;
  shape.at = {0.3, -0.2, 0.5};
  shape.size = {1, 0.7, 0.4};
  shape.radius = kind == Shape::Kind::torus ? 0.5 : 0.4;
  shape.tube = 0.2;
  shape.height = 0.9;
  return shape;
}

Shape rotated(Shape shape) {
  shape.rotate_axis = Vector3(1, 2, -0.5).normalized();
  shape.rotate_degrees = 37;
  return shape;
}

/// reference: whole multiples of the spacing; points = origin + axes * reference; z slowest, x fastest.
void expect_lattice(const Sampling& sampling, double spacing) {
  ASSERT_EQ(sampling.points.size(), sampling.reference.size());
  EXPECT_LT((sampling.axes.transpose() * sampling.axes - Matrix3::Identity()).norm(), 1e-14);
  EXPECT_NEAR(sampling.axes.determinant(), 1, 1e-14);
  double worst = 0;
  bool ordered = true, whole = true;
  for (std::size_t i = 0; i < sampling.points.size(); ++i) {
    const Vector3& r = sampling.reference[i];
    worst = std::max(worst, (sampling.origin + sampling.axes * r - sampling.points[i]).norm());
    for (int k = 0; k < 3; ++k) whole = whole && r[k] == spacing * std::round(r[k] / spacing);
    if (i == 0) continue;
    const Vector3& q = sampling.reference[i - 1];
    ordered = ordered && std::array{q[2], q[1], q[0]} < std::array{r[2], r[1], r[0]};
  }
  EXPECT_LT(worst, 1e-12);
  EXPECT_TRUE(whole);
  EXPECT_TRUE(ordered);
}

void expect_surface(const Sampling& sampling, double tolerance) {
  ASSERT_TRUE(sampling.surface.has_value());
  const MeshReport report = examine(*sampling.surface);
  EXPECT_EQ(report.open_edges + report.odd_edges + report.degenerate + report.crossing_pairs, 0u);
  EXPECT_NEAR(report.volume / sampling.volume, 1, tolerance);
}

TEST(SampleBox, IsFilledExactly) {
  for (const auto& [n, m, k] : {std::array{10, 3, 5}, {4, 4, 4}, {1, 1, 1}, {2, 1, 7}, {30, 3, 3}})
    for (const double h : {0.1, 0.02, 1.0 / 3})
      for (const double off : {0.0, 4e-7, -4e-7}) {
        Shape shape = shape_of(Shape::Kind::box);
        shape.size = Vector3(n, m, k) * h * (1 + off);
        const Sampling sampling = sample(shape, h, "");
        ASSERT_EQ(sampling.points.size(), static_cast<std::size_t>(n * m * k));
        expect_lattice(sampling, h);
        Vector3 low = sampling.points[0], high = low;
        for (const Vector3& p : sampling.points) {
          low = low.cwiseMin(p);
          high = high.cwiseMax(p);
        }
        EXPECT_LT((high - low - Vector3(n - 1, m - 1, k - 1) * h).norm(), 1e-12);
        EXPECT_LT(((high + low) / 2 - shape.at).norm(), 1e-12);
        EXPECT_DOUBLE_EQ(sampling.volume, shape.size.prod());
      }
}

TEST(SampleBox, SidesBetweenMultiplesTakeTheNearer) {
  Shape shape = shape_of(Shape::Kind::box);
  shape.size = {2.3, 2.6, 3.4};
  EXPECT_EQ(sample(shape, 1, "").points.size(), 2u * 3 * 3);
}

TEST(SampleBox, SurfaceHasEdgesOfASpacingUpToALimit) {
  Shape shape = shape_of(Shape::Kind::box);
  shape.size = {1, 0.3, 0.2};
  const Sampling coarse = sample(shape, 0.05, "");
  EXPECT_EQ(coarse.surface->triangles.size(), 4u * (20 * 6 + 6 * 4 + 4 * 20));
  expect_surface(coarse, 1e-12);
  const Sampling fine = sample(shape, 0.004, "");
  EXPECT_LT(fine.surface->triangles.size(), 21000u);
  EXPECT_GT(fine.surface->triangles.size(), 15000u);
  expect_surface(fine, 1e-12);
}

TEST(SampleAnalytic, CountsFollowTheVolume) {
  for (const auto kind : {Shape::Kind::sphere, Shape::Kind::cylinder, Shape::Kind::torus}) {
    const double h = 0.02;
    const Shape shape = shape_of(kind);
    const Sampling sampling = sample(shape, h, "");
    expect_lattice(sampling, h);
    expect_surface(sampling, 0.01); // flat triangles between points of a round surface
    EXPECT_NEAR(double(sampling.points.size()) * h * h * h / sampling.volume, 1, 0.01) << name_of(shape);
    EXPECT_GT(sampling.surface->triangles.size(), 1000u);
    EXPECT_LE(sampling.surface->triangles.size(), 21000u);
    const ShapeQuery query(shape, "");
    for (const Vector3& p : sampling.points) ASSERT_LE(query.signed_distance(p), 1e-6 * h);
    Vector3 centre = Vector3::Zero();
    for (const Vector3& p : sampling.points) centre += p / double(sampling.points.size());
    EXPECT_LT((centre - shape.at).norm(), 1e-12); // the lattice is symmetric about the centre
  }
}

TEST(SampleAnalytic, CylinderHasWholeLayers) {
  Shape shape = shape_of(Shape::Kind::cylinder);
  shape.height = 5 * 0.1;
  const Sampling sampling = sample(shape, 0.1, "");
  double low = 1e9, high = -1e9;
  for (const Vector3& p : sampling.points) {
    low = std::min(low, p[1]);
    high = std::max(high, p[1]);
  }
  EXPECT_NEAR(high - low, 0.4, 1e-12);
}

TEST(SampleRotated, IsTheSameLatticeTurned) {
  const Folder folder;
  write_mesh(triangulate_torus(2, 0.7, 40, 20), folder / "torus.off");
  for (const auto kind : {Shape::Kind::box, Shape::Kind::sphere, Shape::Kind::cylinder, Shape::Kind::torus,
                          Shape::Kind::mesh}) {
    Shape shape = shape_of(kind);
    shape.mesh = "torus.off";
    shape.place = shape.at;
    shape.fit = 1;
    const Sampling plain = sample(shape, 0.05, folder.path()),
                   turned = sample(rotated(shape), 0.05, folder.path());
    EXPECT_EQ(plain.axes, Matrix3::Identity());
    expect_lattice(turned, 0.05);
    expect_surface(turned, 0.02);
    ASSERT_EQ(plain.reference, turned.reference);
    EXPECT_GT(plain.points.size(), 100u);
    const Matrix3 rotation(Eigen::AngleAxisd(37 * pi / 180, Vector3(1, 2, -0.5).normalized()));
    for (std::size_t i = 0; i < plain.points.size(); ++i)
      ASSERT_LT((shape.at + rotation * (plain.points[i] - shape.at) - turned.points[i]).norm(), 1e-12);
    for (std::size_t i = 0; i < plain.surface->vertices.size(); ++i)
      ASSERT_LT((shape.at + rotation * (plain.surface->vertices[i] - shape.at) - turned.surface->vertices[i])
                    .norm(),
                1e-12);
  }
}

Shape mesh_shape(const std::string& name) {
  Shape shape;
  shape.kind = Shape::Kind::mesh;
  shape.mesh = name;
  return shape;
}

TEST(SampleMesh, FitAndPlaceScaleAndMoveTheBox) {
  const Folder folder;
  Mesh mesh = triangulate_box({4, 2, 1}, {1, 1, 1});
  for (Vector3& v : mesh.vertices) v += Vector3(10, 0, 3);
  write_mesh(mesh, folder / "box.stl");
  Shape shape = mesh_shape("box.stl");
  const Sampling stays = sample(shape, 0.5, folder.path());
  EXPECT_EQ(stays.points.size(), 8u * 4 * 2);
  EXPECT_NEAR(stays.volume, 8, 1e-12);
  MeshReport report = examine(*stays.surface);
  EXPECT_LT((report.low - Vector3(8, -1, 2.5)).norm() + (report.high - Vector3(12, 1, 3.5)).norm(), 1e-12);
  shape.fit = 1;
  shape.place = {0, 1.2, 0};
  const Sampling fitted = sample(shape, 0.125, folder.path());
  EXPECT_EQ(fitted.points.size(), 8u * 4 * 2);
  EXPECT_NEAR(fitted.volume, 8.0 / 64, 1e-12);
  report = examine(*fitted.surface);
  EXPECT_LT((report.low - Vector3(-0.5, 0.95, -0.125)).norm() +
                (report.high - Vector3(0.5, 1.45, 0.125)).norm(),
            1e-12);
  EXPECT_TRUE(fitted.warnings.empty());
}

TEST(SampleMesh, HoldsThePointsWhoseExactWindingNumberSaysInside) {
  const Folder folder;
  const Mesh mesh = join(triangulate_sphere(0.5, 6), triangulate_torus(0.5, 0.2, 24, 12), {0.4, 0.1, 0});
  write_mesh(mesh, folder / "two.ply");
  Shape shape = mesh_shape("two.ply");
  const double h = 0.09;
  const Sampling sampling = sample(shape, h, folder.path());
  expect_lattice(sampling, h);
  ASSERT_EQ(sampling.warnings.size(), 1u);
  EXPECT_THAT(sampling.warnings[0], HasSubstr(std::to_string(examine(mesh).crossing_pairs) + " pairs"));
  const auto at = [&](long i, long j, long k) {
    return Vector3(sampling.origin + h * Vector3(double(i), double(j), double(k)));
  };
  std::size_t next = 0;
  for (long k = -10; k <= 10; ++k)
    for (long j = -10; j <= 10; ++j)
      for (long i = -10; i <= 10; ++i)
        if (exact_winding(mesh, at(i, j, k)) > 0.5) {
          ASSERT_LT(next, sampling.points.size());
          ASSERT_LT((sampling.points[next++] - at(i, j, k)).norm(), 1e-12);
        }
  EXPECT_EQ(next, sampling.points.size());
}

TEST(SampleMesh, RefusesOpenAndFlatMeshesAndTurnsInwardOnes) {
  const Folder folder;
  Mesh mesh = triangulate_sphere(1, 6);
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  write_mesh(mesh, folder / "inward.off");
  const Sampling turned = sample(mesh_shape("inward.off"), 0.2, folder.path());
  EXPECT_NEAR(turned.volume / (4 * pi / 3), 1, 0.04);
  expect_surface(turned, 1e-12);
  ASSERT_EQ(turned.warnings.size(), 1u);
  EXPECT_THAT(turned.warnings[0], HasSubstr("inwards"));
  mesh.triangles.pop_back();
  write_mesh(mesh, folder / "open.off");
  const std::string message =
      error_of(ExitCode::usage, [&] { sample(mesh_shape("open.off"), 0.2, folder.path()); });
  EXPECT_THAT(message, HasSubstr("open.off"));
  EXPECT_THAT(message, HasSubstr("3 of its edges"));
  Mesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  write_mesh(flat, folder / "flat.off");
  EXPECT_THAT(error_of(ExitCode::usage, [&] { sample(mesh_shape("flat.off"), 0.2, folder.path()); }),
              HasSubstr("no volume"));
}

TEST(Sample, NamesTheSpacingThatWouldDo) {
  const Folder folder;
  write_mesh(triangulate_torus(1, 0.1, 32, 16), folder / "ring.off");
  for (const auto kind : {Shape::Kind::box, Shape::Kind::sphere, Shape::Kind::cylinder, Shape::Kind::torus,
                          Shape::Kind::mesh}) {
    Shape shape = rotated(shape_of(kind));
    shape.size = {1, 0.013, 1};
    shape.tube = 0.01;
    shape.mesh = "ring.off";
    const std::string message = error_of(ExitCode::usage, [&] { sample(shape, 5, folder.path()); });
    const std::string before = "a spacing of ";
    const std::size_t number = message.rfind(before);
    ASSERT_NE(number, std::string::npos) << message;
    const double spacing = std::stod(message.substr(number + before.size()));
    EXPECT_LT(spacing, 5) << message;
    EXPECT_GE(sample(shape, spacing, folder.path()).points.size(), 1u) << message;
  }
}

TEST(Sample, RefusesImpossibleSizes) {
  const auto refused = [](Shape shape, double spacing, ExitCode code = ExitCode::usage) {
    return error_of(code, [&] { sample(shape, spacing, ""); });
  };
  Shape shape = shape_of(Shape::Kind::torus);
  shape.tube = 0.6;
  EXPECT_THAT(refused(shape, 0.1), HasSubstr("thinner than its ring"));
  shape = shape_of(Shape::Kind::sphere);
  EXPECT_THAT(refused(shape, 0), HasSubstr("spacing"));
  EXPECT_THAT(refused(shape, 1e-5, ExitCode::too_large), HasSubstr("Raise the spacing"));
  shape.radius = -1;
  EXPECT_THAT(refused(shape, 0.1), HasSubstr("radius is -1 m"));
  EXPECT_THAT(refused(shape_of(Shape::Kind::plane), 0.1), HasSubstr("plane"));
  EXPECT_THAT(refused(mesh_shape("no-such-mesh.off"), 0.1), HasSubstr("no-such-mesh.off"));
}

/// Unsigned distance by search: the nearest of the points of a fine triangulation's triangles; sign by
/// `contains`.
TEST(ShapeQuery, SignedDistancesAgreeWithTheNearestPointOfAFineSurface) {
  Random random(7);
  for (const auto kind : {Shape::Kind::box, Shape::Kind::sphere, Shape::Kind::cylinder, Shape::Kind::torus}) {
    const Shape shape = rotated(shape_of(kind));
    const ShapeQuery query(shape, "");
    const PlacedShape placed = place(shape, "");
    Mesh fine = kind == Shape::Kind::box        ? triangulate_box(shape.size, {1, 1, 1})
                : kind == Shape::Kind::sphere   ? triangulate_sphere(shape.radius, 48)
                : kind == Shape::Kind::cylinder ? triangulate_cylinder(shape.radius, shape.height, 256, 1, 1)
                                                : triangulate_torus(shape.radius, shape.tube, 256, 128);
    for (Vector3& v : fine.vertices) v = placed.to_world(v);
    const MeshQuery surface(fine);
    // How far the flat triangles lie below the round surface: r (1 - cos of half the angle of an edge or
    // diagonal).
    const double sag = kind == Shape::Kind::box ? 1e-12 : 4e-4;
    int inside = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vector3 p = shape.at + random.vector(i % 4 == 0 ? 2 : 0.6);
      const double distance = query.signed_distance(p), reference = surface.distance(p);
      ASSERT_NEAR(std::abs(distance), reference, sag) << name_of(shape) << " at " << p.transpose();
      EXPECT_EQ(query.contains(p), distance <= 0);
      if (reference < 2 * sag) continue;
      inside += distance < 0;
      ASSERT_EQ(distance<0, surface.winding_number(p)> 0.5) << name_of(shape) << " at " << p.transpose();
    }
    EXPECT_GT(inside, 50);
    EXPECT_NEAR(examine(query.surface()).volume / volume_of(placed), 1, 0.03);
  }
}

TEST(ShapeQuery, PlaneAndMesh) {
  Shape plane = shape_of(Shape::Kind::plane);
  plane.normal = Vector3(0, 3, 4) / 5;
  plane.offset = 0.5;
  const ShapeQuery floor(plane, "");
  EXPECT_NEAR(floor.signed_distance({7, 3, 4}), 4.5, 1e-14);
  EXPECT_NEAR(floor.signed_distance({7, 0, 0}), -0.5, 1e-14);
  EXPECT_TRUE(floor.contains({0, 0, 0}));
  EXPECT_FALSE(floor.contains({0, 3, 4}));
  EXPECT_TRUE(floor.surface().triangles.empty());

  const Folder folder;
  Mesh mesh = triangulate_box({2, 1, 1}, {2, 1, 1});
  mesh.triangles.pop_back(); // open: the winding number closes the hole
  write_mesh(mesh, folder / "crate.obj");
  Shape crate = mesh_shape("crate.obj");
  crate.place = {1, 2, 3};
  crate.rotate_axis = {0, 1, 0};
  crate.rotate_degrees = 90;
  const ShapeQuery query(crate, folder.path());
  EXPECT_TRUE(query.contains({1, 2, 3.9})); // its long side now along z
  EXPECT_FALSE(query.contains({1.9, 2, 3}));
  EXPECT_NEAR(query.signed_distance({1, 3.5, 3}), 1, 1e-12);
  EXPECT_NEAR(query.signed_distance({1, 2, 3.75}), -0.25, 1e-12);
  EXPECT_EQ(query.surface().triangles.size(), mesh.triangles.size());
}

TEST(SampleMesh, ArmadilloIsQuick) {
  const auto file = cached("armadillo.off");
  if (file.empty()) GTEST_SKIP() << "armadillo.off is not in the cache";
  Shape shape = mesh_shape(file.string());
  shape.fit = 1;
  const double h = 0.0133;
  const auto begin = std::chrono::steady_clock::now();
  const Sampling sampling = sample(shape, h, "");
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("armadillo: %zu particles in %.2f s\n", sampling.points.size(), seconds);
  EXPECT_NEAR(double(sampling.points.size()) * h * h * h / sampling.volume, 1, 0.01);
  expect_lattice(sampling, h);
}

} // namespace
} // namespace pliant::test
