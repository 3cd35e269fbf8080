// What a mesh measures, inside and outside, distances and crossing triangles, against formulas and brute
// force.
#include "tests/geometry/meshes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace pliant::test {
namespace {

void expect_clean(const MeshReport& report) {
  EXPECT_EQ(report.open_edges, 0u);
  EXPECT_EQ(report.odd_edges, 0u);
  EXPECT_EQ(report.degenerate, 0u);
  EXPECT_EQ(report.crossing_pairs, 0u);
}

TEST(Examine, SphereApproachesItsFormulasAsTheSquareOfTheEdge) {
  const double r = 0.7, volume = 4 * pi / 3 * r * r * r, area = 4 * pi * r * r;
  double last_volume = 0, last_area = 0;
  for (const std::uint32_t cells : {8u, 16u, 32u}) {
    const MeshReport report = examine(triangulate_sphere(r, cells));
    expect_clean(report);
    // Corners on the sphere, edges e: at most a right triangle of legs e, on average e^2 / 6 below the
    // sphere. That is e^2 / 2 of the volume; projecting it outwards, e^2 / 4 of the area.
    const double volume_error = 1 - report.volume / volume, area_error = 1 - report.area / area;
    const double edge = pi / 2 / cells;
    EXPECT_GT(volume_error, 0);
    EXPECT_LT(volume_error, edge * edge / 2);
    EXPECT_GT(area_error, 0);
    EXPECT_LT(area_error, edge * edge / 4);
    if (last_volume > 0) {
      EXPECT_NEAR(last_volume / volume_error, 4, 0.15);
      EXPECT_NEAR(last_area / area_error, 4, 0.15);
    }
    last_volume = volume_error;
    last_area = area_error;
  }
}

TEST(Examine, TorusApproachesItsFormulasAsTheSquareOfTheEdge) {
  const double ring = 1, tube = 0.3, volume = 2 * pi * pi * ring * tube * tube,
               area = 4 * pi * pi * ring * tube;
  double last_volume = 0, last_area = 0;
  for (const std::uint32_t around : {48u, 96u}) {
    const MeshReport report = examine(triangulate_torus(ring, tube, around, around / 2));
    expect_clean(report);
    const double volume_error = std::abs(1 - report.volume / volume),
                 area_error = std::abs(1 - report.area / area);
    EXPECT_LT(volume_error, 0.02);
    EXPECT_LT(area_error, 0.01);
    if (last_volume > 0) {
      EXPECT_NEAR(last_volume / volume_error, 4, 0.2);
      EXPECT_NEAR(last_area / area_error, 4, 0.2);
    }
    last_volume = volume_error;
    last_area = area_error;
  }
}

TEST(Examine, CylinderIsAPrismAndABoxIsExact) {
  const std::uint32_t n = 24;
  const MeshReport prism = examine(triangulate_cylinder(0.5, 2, n, 7, 3));
  expect_clean(prism);
  const double base = n * 0.5 * 0.25 * std::sin(2 * pi / n);
  EXPECT_NEAR(prism.volume, 2 * base, 1e-13);
  EXPECT_NEAR(prism.area, 2 * base + 2 * n * std::sin(pi / n), 1e-13);
  const MeshReport box = examine(triangulate_box({2, 3, 0.5}, {4, 5, 1}));
  expect_clean(box);
  EXPECT_NEAR(box.volume, 3, 1e-13);
  EXPECT_NEAR(box.area, 2 * (6 + 1.5 + 1), 1e-13);
  EXPECT_LT((box.low - Vector3(-1, -1.5, -0.25)).norm() + (box.high - Vector3(1, 1.5, 0.25)).norm(), 1e-15);
}

TEST(Examine, CountsOpenAndOddEdgesAndTrianglesWithoutArea) {
  Mesh mesh = triangulate_box({1, 1, 1}, {2, 2, 2});
  const Mesh whole = mesh;
  mesh.triangles.pop_back();
  EXPECT_EQ(examine(mesh).open_edges, 3u);
  EXPECT_EQ(examine(mesh).odd_edges, 0u);
  mesh = whole;
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  EXPECT_EQ(examine(mesh).open_edges, 0u);
  EXPECT_EQ(examine(mesh).odd_edges, 3u);
  mesh = whole;
  mesh.triangles.push_back(mesh.triangles[0]);
  EXPECT_EQ(examine(mesh).odd_edges, 3u);
  mesh = whole;
  const auto [a, b, c] = mesh.triangles[0];
  mesh.triangles.push_back({a, b, a});
  EXPECT_EQ(examine(mesh).degenerate, 1u);
  EXPECT_EQ(examine(mesh).open_edges + examine(mesh).odd_edges, 0u);
  EXPECT_EQ(examine(Mesh{}).area, 0);
}

TEST(Orientation, IsExactWhereRoundingHidesTheSign) {
  // Points on the plane z = x + y of a fine grid far from the origin: the volume is 0; one last bit decides
  // the sign.
  Random random(1);
  int decided = 0;
  for (int i = 0; i < 2000; ++i) {
    std::array<Vector3, 4> p;
    for (Vector3& v : p) {
      const double x = 1 + std::ldexp(std::floor(random.in(0, 1024)), -50),
                   y = 1 + std::ldexp(std::floor(random.in(0, 1024)), -50);
      v = {x, y, x + y - 2}; // exact: multiples of 2^-50 below 2
    }
    EXPECT_EQ(orientation(p[0], p[1], p[2], p[3]), 0);
    Vector3 up = p[3], down = p[3];
    up[2] += std::ldexp(1, -60);
    down[2] -= std::ldexp(1, -60);
    const int turn =
        orientation(p[0], p[1], p[2], p[0] + Vector3(0, 0, -1)); // + where counter-clockwise from above
    if (turn == 0 || up[2] == p[3][2] || down[2] == p[3][2]) continue;
    ++decided;
    EXPECT_EQ(orientation(p[0], p[1], p[2], up), -turn);
    EXPECT_EQ(orientation(p[0], p[1], p[2], down), turn);
  }
  EXPECT_GT(decided, 1000);
}

/// Whether the segment passes through the triangle, in plain double.
bool passes(const Vector3& a, const Vector3& b, const Corners& t) {
  const Vector3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double x = normal.dot(a - t[0]), y = normal.dot(b - t[0]);
  if (x * y >= 0) return false;
  const Vector3 p = a + (b - a) * (x / (x - y));
  for (std::size_t k = 0; k < 3; ++k)
    if (normal.dot((t[(k + 1) % 3] - t[k]).cross(p - t[k])) < 0) return false;
  return true;
}

TEST(TrianglesCross, AgreesWithEdgesPassingThroughFaces) {
  Random random(2);
  int crossing = 0;
  for (int i = 0; i < 50000; ++i) {
    Corners p, q;
    for (Vector3& v : p) v = random.vector(1);
    for (Vector3& v : q) v = random.vector(1);
    bool expected = false;
    for (std::size_t k = 0; k < 3; ++k)
      expected = expected || passes(p[k], p[(k + 1) % 3], q) || passes(q[k], q[(k + 1) % 3], p);
    crossing += expected;
    ASSERT_EQ(triangles_cross(p, q), expected) << "triangle pair " << i << " of seed 2";
  }
  EXPECT_GT(crossing, 5000);
}

TEST(TrianglesCross, TouchingIsNotCrossingButOverlappingInAPlaneIs) {
  const Corners flat{Vector3(0, 0, 0), Vector3(4, 0, 0), Vector3(0, 4, 0)};
  const auto moved = [&](const Vector3& by) { return Corners{flat[0] + by, flat[1] + by, flat[2] + by}; };
  EXPECT_TRUE(triangles_cross(flat, moved({1, 1, 0})));
  EXPECT_FALSE(triangles_cross(flat, moved({4, 0, 0}))); // a corner in common
  EXPECT_FALSE(triangles_cross(flat, moved({2, 2, 0}))); // a corner on the long edge
  EXPECT_FALSE(triangles_cross(flat, moved({5, 0, 0})));
  EXPECT_FALSE(triangles_cross(flat, moved({0, 0, 1e-300})));
  EXPECT_FALSE(triangles_cross(flat, {Vector3(1, 1, 0), Vector3(1, 1, 1), Vector3(2, 1, 1)})); // stands on it
  EXPECT_TRUE(triangles_cross(flat, {Vector3(1, 1, -1e-300), Vector3(1, 1, 1), Vector3(2, 1, 1)}));
  EXPECT_FALSE(
      triangles_cross(flat, {Vector3(0, 0, -1), Vector3(0, 0, 1), Vector3(-1, 0, 0)})); // edge at a corner
}

TEST(CrossingPairs, TwoSpheresThatOverlapMatchBruteForce) {
  const Mesh sphere = triangulate_sphere(1, 8), mesh = join(sphere, sphere, {0.9, 0.21, 0.13});
  std::size_t expected = 0;
  for (std::size_t i = 0; i < sphere.triangles.size(); ++i)
    for (std::size_t j = sphere.triangles.size(); j < mesh.triangles.size(); ++j)
      expected += triangles_cross(corners_of(mesh, i), corners_of(mesh, j));
  EXPECT_GT(expected, 40u);
  EXPECT_EQ(examine(mesh).crossing_pairs, expected);
  EXPECT_EQ(examine(join(sphere, sphere, {2.1, 0, 0})).crossing_pairs, 0u);
}

TEST(WindingNumber, WithinAThousandthOfTheExactSum) {
  Random random(3);
  for (const Mesh& mesh :
       {triangulate_sphere(1, 24), triangulate_torus(1, 0.3, 96, 32),
        join(triangulate_sphere(1, 16), triangulate_torus(0.8, 0.3, 64, 24), {0.7, 0.1, 0})}) {
    const MeshQuery query(mesh);
    double worst = 0, worst_near = 0;
    for (int i = 0; i < 400; ++i) {
      const Vector3 p = random.vector(1.6);
      worst = std::max(worst, std::abs(query.winding_number(p) - exact_winding(mesh, p)));
      const Corners t =
          corners_of(mesh, static_cast<std::size_t>(random.in(0, 1) * double(mesh.triangles.size())));
      const Vector3 near = (t[0] + t[1] + t[2]) / 3 + random.vector(0.003);
      worst_near = std::max(worst_near, std::abs(query.winding_number(near) - exact_winding(mesh, near)));
    }
    std::printf("winding number: worst error %.1e, near the surface %.1e (limit 1e-3)\n", worst, worst_near);
    EXPECT_LT(worst, 1e-3);
    EXPECT_LT(worst_near, 1e-3);
    EXPECT_NEAR(query.winding_number({0.31, 0.2, 0.1}, 1e9), exact_winding(mesh, {0.31, 0.2, 0.1}), 1e-12);
  }
}

TEST(WindingNumber, TellsInsideFromOutside) {
  const Mesh torus = triangulate_torus(1, 0.3, 96, 48);
  const MeshQuery query(torus);
  Shape shape;
  shape.kind = Shape::Kind::torus;
  shape.radius = 1;
  shape.tube = 0.3;
  Random random(4);
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3 p = random.vector(1).cwiseProduct(Vector3(1.4, 0.4, 1.4));
    const double distance = analytic_distance(shape, p);
    if (std::abs(distance) < 2e-3) continue; // between the facets and the torus
    inside += distance < 0;
    EXPECT_NEAR(query.winding_number(p), distance < 0 ? 1 : 0, 1e-3) << p.transpose();
  }
  EXPECT_GT(inside, 500);
}

TEST(WindingNumber, CountsTwiceWhereAMeshOverlapsItself) {
  const Mesh sphere = triangulate_sphere(1, 12);
  const MeshQuery query(join(sphere, sphere, {1, 0.1, 0}));
  EXPECT_NEAR(query.winding_number({0.5, 0, 0}), 2, 1e-3);
  EXPECT_NEAR(query.winding_number({-0.5, 0, 0}), 1, 1e-3);
  EXPECT_NEAR(query.winding_number({1.5, 0, 0}), 1, 1e-3);
  EXPECT_NEAR(query.winding_number({0.5, 1.5, 0}), 0, 1e-3);
}

TEST(Distance, IsTheNearestOfAllTriangles) {
  Mesh mesh = join(triangulate_sphere(1, 10), triangulate_torus(0.8, 0.3, 24, 12), {0.7, 0.1, 0});
  mesh.triangles.push_back({0, 1, 0}); // no area: must do no harm
  const MeshQuery query(mesh);
  Random random(5);
  for (int i = 0; i < 500; ++i) {
    const Vector3 p = random.vector(i % 2 ? 1.5 : 20.0);
    double expected = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      expected = std::min(expected, (nearest_on_triangle(corners_of(mesh, t), p) - p).norm());
    Vector3 nearest;
    EXPECT_EQ(query.distance(p, &nearest), expected);
    EXPECT_NEAR((nearest - p).norm(), expected, 1e-14 * expected);
  }
}

TEST(Distance, NearestPointOfATriangleAgainstAFineGridOnIt) {
  Random random(6);
  for (int i = 0; i < 300; ++i) {
    const Corners t{random.vector(1), random.vector(1), random.vector(1)};
    const Vector3 p = random.vector(2);
    double grid = std::numeric_limits<double>::infinity();
    const int n = 200;
    for (int a = 0; a <= n; ++a)
      for (int b = 0; a + b <= n; ++b)
        grid = std::min(grid, (t[0] + (t[1] - t[0]) * a / n + (t[2] - t[0]) * b / n - p).norm());
    const double exact = (nearest_on_triangle(t, p) - p).norm();
    EXPECT_LE(exact, grid + 1e-12);
    EXPECT_GE(exact, grid - 3.5 / n); // a grid cell is at most sqrt(12) / n long
  }
}

TEST(Examine, ArmadilloIsCleanAndQuick) {
  const auto file = cached("armadillo.off");
  if (file.empty()) GTEST_SKIP() << "armadillo.off is not in the cache";
  const Mesh mesh = read_mesh(file);
  const auto begin = std::chrono::steady_clock::now();
  const MeshReport report = examine(mesh);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("armadillo: %zu triangles examined in %.2f s\n", mesh.triangles.size(), seconds);
  expect_clean(report);
  EXPECT_GT(report.volume, 0);
}

} // namespace
} // namespace pliant::test
