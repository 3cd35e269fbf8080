// Laws over bonds in sheets: what they return of the constants typed, and directions in the plane of a sheet.
#include "engine/model/anisotropy.h"
#include "tests/laws/materials.h"
#include "tests/scene/parse.h"
#include "tests/sheets/sheets.h"

#include "engine/scene/mesh.h"

#include <filesystem>
#include <numbers>
#include <unistd.h>

namespace pliant::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double spacing = 0.1, thickness = 0.004, young = 2e5;

/// A sheet of so many particles of a material.
Scene sheet_of(const Material& material, int length, int width, const Vector3& axis = Vector3::UnitY(),
               double degrees = 0) {
  FlatScene made = sheet_scene();
  made.width = spacing * length, made.height = spacing * width;
  Scene scene = made.scene();
  scene.materials = {material};
  scene.bodies[0].material = material.name;
  scene.bodies[0].shape.rotate_axis = axis.normalized();
  scene.bodies[0].shape.rotate_degrees = degrees;
  return scene;
}

/// Energy to an area, J/m2, deep inside a sheet of which every bond follows Y = F xi, by the engine: longer
/// less shorter, wider less narrower, so that rims and corners cancel.
std::vector<double> inner_energy(Device& device, const Material& material, const std::vector<Matrix3>& fs) {
  std::vector<double> found(fs.size(), 0);
  for (const auto& [length, width, sign] :
       {std::tuple{16, 16, 1}, std::tuple{12, 16, -1}, std::tuple{16, 12, -1}, std::tuple{12, 12, 1}}) {
    const Scene scene = sheet_of(material, length, width);
    const Model model = assemble(scene);
    Simulation simulation(device, scene, model);
    for (std::size_t k = 0; k < fs.size(); ++k) {
      Points y = model.position;
      for (Vector3& v : y) v = fs[k] * v;
      found[k] += sign * simulation.elastic_energy(y) / (16 * spacing * spacing);
    }
  }
  return found;
}

Matrix3 in_plane(double xx, double yy, double xy) {
  Matrix3 e = Matrix3::Zero();
  e(0, 0) = xx, e(1, 1) = yy, e(0, 1) = e(1, 0) = xy;
  return e;
}

// The lattice's fourth moments are matched, so that its constants are those of the continuum. Both signs of a
// strain, so that the energies' third derivatives cancel; the fourth leave its square, 1e-8 times about 10.
TEST(SheetLaws, SmallStrainsReturnWhatWasTyped) {
  const auto device = open_double();
  for (const double nu : {0.0, 0.3, 0.6})
    for (const auto& [name, material] : some_materials(young, nu)) {
      if (material.volume_basis != material.bond_basis) continue; // not convex at each of these ratios
      const double e = 1e-4;
      std::vector<Matrix3> fs;
      for (const Matrix3& strain :
           {in_plane(1, 0, 0), in_plane(0, 1, 0), in_plane(1, 1, 0), in_plane(0, 0, 1)})
        for (const double size : {e, -e}) fs.push_back(Matrix3::Identity() + size * strain);
      const std::vector<double> w = inner_energy(*device, material, fs);
      const auto curvature = [&](std::size_t k) { return (w[2 * k] + w[2 * k + 1]) / (e * e * thickness); };
      const double c11 = curvature(0), c22 = curvature(1), c12 = (curvature(2) - c11 - c22) / 2,
                   c33 = curvature(3) / 4;
      const std::string what = fmt::format("{}, ratio {}: ", name, nu);
      expect_below(what + "|E / E0 - 1|", std::abs((c11 - c12 * c12 / c22) / young - 1), 1e-6);
      expect_below(what + "|nu - nu0|", std::abs(c12 / c22 - nu), 1e-6);
      expect_below(what + "|G / G0 - 1|", std::abs(c33 / (young / (2 * (1 + nu))) - 1), 1e-6);
    }
}

// W = mu E : E + lambda' / 2 (tr E)^2 with lambda' = E nu / (1 - nu^2), of any map of the plane into space.
TEST(SheetLaws, SaintVenantKirchhoffIsThatOfThePlane) {
  const auto device = open_double();
  std::mt19937 random(3);
  for (const double nu : {0.0, 0.3, 0.6}) {
    std::vector<Matrix3> fs;
    for (int k = 0; k < 10; ++k) {
      Matrix3 f = Eigen::AngleAxisd(k, random_vector(random).normalized()).toRotationMatrix();
      for (int c = 0; c < 2; ++c) f.col(c) += 0.5 * random_vector(random);
      fs.push_back(f);
    }
    const std::vector<double> w = inner_energy(*device, formed("stvk", "exact", young, nu), fs);
    double worst = 0;
    for (std::size_t k = 0; k < fs.size(); ++k) {
      const Eigen::Matrix<double, 3, 2> f = fs[k].leftCols<2>();
      const Eigen::Matrix2d e = (f.transpose() * f - Eigen::Matrix2d::Identity()) / 2;
      const double mu = young / (2 * (1 + nu)), lame = young * nu / (1 - nu * nu);
      const double exact = thickness * (mu * e.squaredNorm() + lame / 2 * e.trace() * e.trace());
      worst = std::max(worst, std::abs(w[k] / exact - 1));
    }
    expect_below(fmt::format("ratio {}: energy against the closed formula, less 1", nu), worst, 1e-9);
  }
}

Material directed(const Vector3& strengths, const Matrix3& rows = Matrix3::Identity()) {
  Material material = basis_of(young, 0.3, {{"A4", 1}}, {{"A4", 1}});
  material.anisotropy = directions_of(strengths, rows);
  return material;
}

/// Mean of |Sigma R^T N| over the circle of two unit vectors, by the midpoint rule, which is exact here.
double circle_mean(const Vector3& a, const Vector3& b, const Matrix3& rows, const Vector3& strengths) {
  const int points = 4000;
  double sum = 0;
  for (int k = 0; k < points; ++k) {
    const double t = 2 * std::numbers::pi * (k + 0.5) / points;
    sum += strengths.cwiseProduct(rows * (std::cos(t) * a + std::sin(t) * b)).norm();
  }
  return sum / points;
}

TEST(SheetDirections, AreOneOnAverageInThePlaneOfTheSheet) {
  const Vector3 sigma(4, 0.25, 1);
  const Matrix3 rows = Eigen::AngleAxisd(0.7, Vector3(2, -1, 2) / 3).toRotationMatrix();
  const Vector3 axis(1, 2, 3);
  const Scene scene = sheet_of(directed(sigma, rows), 8, 7, axis, 50);
  const Model model = assemble(scene);
  const Matrix3& axes = model.bodies[0].axes;
  const double mean = circle_mean(axes.col(0), axes.col(1), rows, sigma);
  double worst = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i)
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const Vector3 n = axes * (model.reference[model.bonds.neighbour[b]] - model.reference[i]).normalized();
      worst = std::max(worst, std::abs(model.bonds.strength[b] - sigma.cwiseProduct(rows * n).norm() / mean));
    }
  expect_below("G against |Sigma R^T N| over its mean in the plane", worst, 1e-12);
}

// Over the circle of an ellipse of half axes a > b the mean is 2 a E(k) / pi, k^2 = 1 - (b / a)^2.
TEST(SheetDirections, MeansAreThoseOfAnEllipse) {
  for (const double ratio : {1.0, 0.5, 1. / 16, 1e-3}) {
    const double exact = 4 * 2 / std::numbers::pi * std::comp_ellint_2(std::sqrt(1 - ratio * ratio));
    EXPECT_NEAR(mean_strength(4, 4 * ratio) / exact, 1, 1e-9) << ratio;
    EXPECT_NEAR(mean_strength(4 * ratio, 4) / exact, 1, 1e-9) << ratio;
  }
}

/// Half a pipe of radius 1 about y, two long.
std::string half_pipe(const std::filesystem::path& folder) {
  const int around = 40, along = 8;
  Mesh mesh;
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i <= around; ++i) {
      const double a = std::numbers::pi * i / around;
      mesh.vertices.emplace_back(std::cos(a), 2.0 * j / along - 1, std::sin(a));
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (around + 1) + i); };
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < around; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  write_mesh(mesh, folder / "pipe.obj");
  return (folder / "pipe.obj").string();
}

// On a pipe with directions around its axis each neighbourhood has the same two strengths in its plane: along
// the axis G is sigma_a over their mean, around it sigma_t over it. A bond is a chord, spacing / 2 off the
// tangent to a radius of 1, whose radial strength adds (sigma_r / sigma)^2 (spacing / 2)^2 / 2.
TEST(SheetDirections, FollowACurvedShell) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("pliant-pipe-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const Vector3 sigma(1, 3, 0.5); // radial, tangential, axial
  Material material = directed(sigma);
  material.anisotropy.around = true;
  material.anisotropy.around_axis = Vector3::UnitY();
  Scene scene = sheet_of(material, 8, 8);
  scene.bodies[0].shape = Shape{};
  scene.bodies[0].shape.kind = Shape::Kind::mesh;
  scene.bodies[0].shape.mesh = half_pipe(folder);
  const Model model = assemble(scene);
  std::filesystem::remove_all(folder);
  const double mean = 2 * 3 / std::numbers::pi * std::comp_ellint_2(std::sqrt(1 - 1. / 36));
  double worst = 0;
  std::size_t bonds = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    const Vector3 x = model.position[i];
    const Vector3 radial = Vector3(x.x(), 0, x.z()).normalized();
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const Vector3 n = (model.position[model.bonds.neighbour[b]] - x).normalized();
      const double axial = n.y(),
                   tangential = std::sqrt(std::max(0.0, 1 - axial * axial - std::pow(n.dot(radial), 2)));
      const double wanted = std::hypot(3 * tangential, 0.5 * axial) / mean;
      worst = std::max(worst, std::abs(model.bonds.strength[b] / wanted - 1));
      ++bonds;
    }
  }
  report("bonds", static_cast<double>(bonds));
  expect_below("G against that of the tangent plane, less 1", worst, 0.02);
}

// What turns with its directions does the same turned.
TEST(SheetDirections, TurnWithTheScene) {
  const auto device = open_double();
  const Vector3 sigma(4, 0.25, 1);
  const Vector3 axis(1, 2, 3);
  const Matrix3 turn = Eigen::AngleAxisd(50 * std::numbers::pi / 180, axis.normalized()).toRotationMatrix();
  const Matrix3 rows = Eigen::AngleAxisd(0.4, Vector3(2, -1, 2) / 3).toRotationMatrix();
  Points results[2];
  for (const bool turned : {false, true}) {
    Scene scene = sheet_of(directed(sigma, turned ? Matrix3(rows * turn.transpose()) : rows), 12, 7, axis,
                           turned ? 50 : 0);
    scene.solver.tolerance = 1e-11;
    scene.solver.method = "newton";
    Model model = assemble(scene);
    const Matrix3 axes = model.bodies[0].axes;
    for (std::size_t i = 0; i < model.count(); ++i) {
      const Vector3 x = model.reference[i];
      model.position[i] +=
          axes * Vector3(0.05 * std::sin(3 * x.y()), 0.04 * std::cos(2 * x.x()), 0.03 * x.x() * x.y());
      model.velocity[i] = axes * Vector3(0.2 * x.y(), 0.1, 0.3 * std::sin(5 * x.x()));
    }
    Simulation simulation(*device, scene, model);
    for (int k = 0; k < 6; ++k) simulation.step();
    results[turned] = own_positions(model, simulation.positions());
  }
  expect_below("difference, m", largest_difference(results[0], results[1]), 1e-9);
}

// Equal strengths are none: what differs is the rounding of |Sigma N| / <|Sigma N|>, half a unit in the last
// place each for its root, its quotient, its direction and the mean, twice over.
TEST(SheetDirections, EqualStrengthsChangeNothing) {
  const auto device = open_double();
  Points results[2];
  for (const bool given : {false, true}) {
    Material material = directed({3, 3, 3});
    material.anisotropy.given = given;
    const Scene scene = sheet_of(material, 12, 7);
    Model model = assemble(scene);
    EXPECT_EQ(model.bonds.strength.empty(), !given);
    for (const double g : model.bonds.strength) EXPECT_NEAR(g, 1, 1e-15);
    for (Vector3& x : model.position) x += Vector3(0.05 * std::sin(3 * x.y()), 0, 0.03 * x.x() * x.y());
    Simulation simulation(*device, scene, model);
    for (const Vector3& f : simulation.elastic_forces(model.position)) results[given].push_back(f);
  }
  expect_below("forces, of the largest", largest_difference(results[0], results[1]) / largest(results[0]),
               1e-14);
}

// What has no law in two dimensions is refused where it is typed.
TEST(SheetLaws, RefusedInSheetsAndPlanes) {
  const auto refused = [](const std::string& simulation, const std::string& material,
                          const std::string& body) {
    return complaint("[simulation]\nspacing = 0.1\n" + simulation + "\n[materials.m]\n" + material +
                     "\n[[body]]\nmaterial = \"m\"\n" + body + "\n");
  };
  const std::string sheet = "shape = { sheet = [1, 0.5] }\nthickness = 0.01",
                    box = "shape = { box = [1, 1, 1] }";
  const std::string basis = "law = \"basis\"\nbasis = { g = { A1 = 1 }, h = { A1 = 1 } }\n",
                    xu = "calibration = \"xu2018\"";
  for (const std::string plane : {"", "dimension = 2", "dimension = 2\nplane = \"stress\""}) {
    const std::string& body = plane.empty() ? sheet : box;
    const std::string line = plane.find('\n') == std::string::npos ? "5" : "6";
    EXPECT_THAT(refused(plane, "law = \"neo-hookean\"", body),
                AllOf(StartsWith("s.toml:" + line + ":7: materials.m: "), HasSubstr("form = \"bonds\"")));
    EXPECT_EQ(refused(plane, "law = \"neo-hookean\"\nform = \"bonds\"", body), "");
    EXPECT_THAT(refused(plane, basis + xu, body),
                AllOf(StartsWith("s.toml:"), HasSubstr("\"xu2018\" is of solids")));
    EXPECT_THAT(refused(plane, "law = \"stvk\"\n" + xu, body), HasSubstr("\"xu2018\" is of solids"));
    EXPECT_EQ(refused(plane, basis, body), "");
  }
  EXPECT_EQ(refused("", basis + xu, box), "");
}

} // namespace
} // namespace pliant::test
