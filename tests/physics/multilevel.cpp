// The multilevel preconditioner as an operator: against a finite element matrix assembled here, symmetric and
// positive, and good for smooth errors.
#include "tests/support/solve_rig.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace pliant::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double spacing = 0.1;
/// Leaves nothing of the particles' own share: the coarse levels alone.
constexpr double coarse_alone = 1e12;

Stage stage_of(const Points& points, double young, double poisson, const char* law = "corotated") {
  Stage stage(points, spacing, material_of(law, young, poisson), 1. / 60);
  stage.model =
      assemble_points(points, spacing, 1.87, stage.scene.materials[0], std::pow(spacing, 3), "normalised");
  stage.scene.solver.method = "newton";
  stage.scene.solver.preconditioner = "multilevel";
  return stage;
}

Points l_shape() {
  Points points;
  for (const Vector3& x : lattice(5, 4, 2, spacing))
    if (x.x() < 0.15 || x.y() < 0.15) points.push_back(x);
  return points;
}
Points irregular() {
  std::mt19937 random(5);
  Points points = lattice(3, 3, 4, spacing);
  for (Vector3& x : points) x += 0.3 * spacing * random_vector(random);
  return points;
}

template <class Apply> MatrixXd dense(std::size_t count, Apply apply) {
  const auto n = static_cast<Eigen::Index>(3 * count);
  MatrixXd matrix(n, n);
  for (Eigen::Index column = 0; column < n; ++column) {
    std::vector<Vector3> v(count, Vector3::Zero());
    v[static_cast<std::size_t>(column / 3)][column % 3] = 1;
    const std::vector<Vector3> result = apply(v);
    for (Eigen::Index row = 0; row < n; ++row)
      matrix(row, column) = result[static_cast<std::size_t>(row / 3)][row % 3];
  }
  return matrix;
}

std::vector<Vector3> turned_field(const Model& model, const Matrix3& turn, double noise) {
  std::mt19937 random(9);
  std::vector<Vector3> u;
  for (const Vector3& x : model.position) u.push_back(turn * x - x + noise * spacing * random_vector(random));
  return u;
}

// A body of eight particles is one cell of eight nodes: what the coarse levels do to a residual is
// N (K + M / h^2)^-1 N^T with K the corotated element's matrix, here from strains of unit displacements.
TEST(Multilevel, OneCellIsTheFiniteElement) {
  const auto device = open_double();
  const Matrix3 turn = Eigen::AngleAxisd(1.1, Vector3(2, -1, 2) / 3).toRotationMatrix();
  for (const double poisson : {0.0, 0.3, 0.45}) {
    const double young = 1e6;
    Stage stage = stage_of(lattice(2, 2, 2, spacing), young, poisson);
    SolveRig rig(*device, stage.scene, stage.model);
    rig.forces(turned_field(stage.model, turn, 0));
    rig.refresh();
    const MatrixXd found = dense(8, [&](const auto& r) { return rig.precondition(r, coarse_alone); });
    const double mu = young / (2 * (1 + poisson)),
                 lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
    const double volume = std::pow(spacing, 3), width = 2 * spacing, per_step2 = 3600;
    MatrixXd k = MatrixXd::Zero(24, 24), shape = MatrixXd::Zero(24, 24);
    const auto one = [](double x, int bit) { return bit ? x : 1 - x; };
    for (int i = 0; i < 8; ++i) {
      const Vector3 x = stage.model.reference[static_cast<std::size_t>(i)] - stage.model.reference[0];
      const Vector3 at =
          x / width + Vector3::Constant(0.25); // a particle is the middle of a cube of a spacing
      for (int q = 0; q < 8; ++q) {
        const Vector3 p = at + 0.25 * Vector3(q & 1 ? 1 : -1, q & 2 ? 1 : -1, q & 4 ? 1 : -1);
        std::vector<Matrix3> strain;
        for (int n = 0; n < 8; ++n) {
          const int b[] = {n & 1, n >> 1 & 1, n >> 2};
          Vector3 slope;
          for (int d = 0; d < 3; ++d) {
            slope[d] = (b[d] ? 1 : -1) / width;
            for (int other = 0; other < 3; ++other)
              if (other != d) slope[d] *= one(p[other], b[other]);
          }
          for (int c = 0; c < 3; ++c) {
            const Matrix3 g = turn.transpose() * (Vector3::Unit(c) * slope.transpose()); // R^T F - 1
            strain.push_back((g + g.transpose()) / 2);
          }
        }
        for (std::size_t r = 0; r < 24; ++r)
          for (std::size_t c = 0; c < 24; ++c)
            k(Eigen::Index(r), Eigen::Index(c)) += volume / 8 *
                                                   (2 * mu * (strain[r].array() * strain[c].array()).sum() +
                                                    lambda * strain[r].trace() * strain[c].trace());
      }
      for (int n = 0; n < 8; ++n)
        for (int c = 0; c < 3; ++c)
          shape(3 * i + c, 3 * n + c) = one(at[0], n & 1) * one(at[1], n >> 1 & 1) * one(at[2], n >> 2);
    }
    MatrixXd mass = MatrixXd::Zero(24, 24);
    for (int i = 0; i < 8; ++i)
      mass += stage.model.mass[0] * shape.middleRows(3 * i, 3).transpose() * shape.middleRows(3 * i, 3);
    k += per_step2 * mass;
    k.diagonal() *= 1 + 1e-5; // the factor's own
    const MatrixXd wanted = shape * k.ldlt().solve(shape.transpose());
    expect_below("one cell, nu " + std::to_string(poisson).substr(0, 4),
                 (found - wanted).norm() / wanted.norm(), 1e-9);
  }
}

struct Case {
  std::string name;
  Stage stage;
};

std::vector<Case> cases() {
  std::vector<Case> found;
  for (const double poisson : {0.3, 0.499}) {
    const std::string nu = ", nu " + std::to_string(poisson).substr(0, 4);
    found.push_back({"block" + nu, stage_of(lattice(4, 3, 3, spacing), 1e8, poisson)});
    found.push_back({"rod" + nu, stage_of(lattice(9, 1, 1, spacing), 1e8, poisson)});
    found.push_back({"bar" + nu, stage_of(lattice(9, 2, 2, spacing), 1e8, poisson)});
    found.push_back({"plate" + nu, stage_of(lattice(5, 4, 1, spacing), 1e8, poisson)});
    found.push_back({"L" + nu, stage_of(l_shape(), 1e8, poisson)});
    found.push_back({"irregular" + nu, stage_of(irregular(), 1e8, poisson)});
  }
  found.push_back({"ordinary, nu 0.45", stage_of(lattice(4, 3, 3, spacing), 1e8, 0.45, "ordinary")});
  Stage soft = stage_of(lattice(4, 3, 3, spacing), 1e3, 0.3);
  found.push_back({"soft", soft});
  Stage held = stage_of(lattice(4, 3, 3, spacing), 1e8, 0.3);
  held.hold([](const Vector3& x) { return x.x() < 0.05; });
  found.push_back({"held", held});
  Stage touching = stage_of(lattice(4, 3, 3, spacing), 1e8, 0.3);
  Boundary floor;
  floor.shape.kind = Shape::Kind::plane;
  floor.shape.offset = touching.model.position[0].y() + 0.1;
  touching.scene.boundaries = {floor};
  found.push_back({"touching", touching});
  return found;
}

// The coarse levels alone are semidefinite, not just their sum with the particles' diagonal, which would hide
// it.
TEST(Multilevel, IsSymmetricAndPositive) {
  const auto device = open_double();
  const Matrix3 turn = Eigen::AngleAxisd(0.6, Vector3(1, 2, -2) / 3).toRotationMatrix();
  for (const Case& one : cases()) {
    SolveRig rig(*device, one.stage.scene, one.stage.model);
    const std::size_t n = one.stage.model.count();
    for (const double noise : {0.0, 0.3}) {
      rig.forces(turned_field(one.stage.model, turn, noise));
      rig.refresh();
      const MatrixXd coarse = dense(n, [&](const auto& r) { return rig.precondition(r, coarse_alone); });
      const MatrixXd whole = dense(n, [&](const auto& r) { return rig.precondition(r); });
      const std::string name = one.name + (noise > 0 ? ", deformed" : "");
      expect_below(name + ": |P - P^T| / |P|", (whole - whole.transpose()).norm() / whole.norm(), 1e-12);
      const VectorXd values =
          Eigen::SelfAdjointEigenSolver<MatrixXd>(coarse, Eigen::EigenvaluesOnly).eigenvalues();
      expect_below(name + ": least eigenvalue of the coarse levels, over the largest, negated",
                   -values[0] / values[values.size() - 1], 1e-12);
      std::vector<Eigen::Index> free;
      for (std::size_t i = 0; i < n; ++i)
        if (one.stage.free_particles()[i])
          for (int c = 0; c < 3; ++c) free.push_back(static_cast<Eigen::Index>(3 * i) + c);
      const MatrixXd part = whole(free, free);
      EXPECT_EQ(Eigen::LLT<MatrixXd>(part).info(), Eigen::Success) << name;
      EXPECT_NEAR(part.norm(), whole.norm(), 1e-14 * whole.norm()) << name << ": held particles take no part";
    }
  }
}

/// Extreme eigenvalues of P^-1 H, of what is free.
std::pair<double, double> spectrum(SolveRig& rig, const Stage& stage, double relief) {
  const std::size_t n = stage.model.count();
  rig.forces(std::vector<Vector3>(n, Vector3::Zero()));
  rig.refresh();
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < n; ++i)
    if (stage.free_particles()[i])
      for (int c = 0; c < 3; ++c) free.push_back(static_cast<Eigen::Index>(3 * i) + c);
  const MatrixXd p = dense(n, [&](const auto& r) { return rig.precondition(r, relief); })(free, free);
  const MatrixXd h = dense(n, [&](const auto& v) { return rig.product(v); })(free, free);
  const MatrixXd root = Eigen::LLT<MatrixXd>(MatrixXd((p + p.transpose()) / 2)).matrixL();
  const MatrixXd both = root.transpose() * h * root;
  const VectorXd values =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(MatrixXd((both + both.transpose()) / 2), Eigen::EigenvaluesOnly)
          .eigenvalues();
  return {values[0], values[values.size() - 1]};
}

// Conjugate gradients' iterations go with the root of the condition number.
TEST(Multilevel, ConditionNumberHardlyDependsOnStiffness) {
  const auto device = open_double();
  const Points bar = lattice(12, 2, 2, spacing);
  for (const double poisson : {0.3, 0.45}) {
    for (const double young : {1e5, 1e7, 1e9}) {
      Stage stage = stage_of(bar, young, poisson);
      SolveRig rig(*device, stage.scene, stage.model);
      const LawConstants& law = stage.model.constants[0];
      const auto [low, high] = spectrum(rig, stage, (1 + 0.15 * law.coupling) / law.bound);
      stage.scene.solver.preconditioner = "diagonal";
      SolveRig plain(*device, stage.scene, stage.model);
      const auto [plain_low, plain_high] = spectrum(plain, stage, 1);
      const std::string name =
          "E " + std::to_string(int(young / 1e3)) + " kPa, nu " + std::to_string(poisson).substr(0, 4);
      report(name + ": condition, diagonal", plain_high / plain_low);
      expect_below(name + ": condition, multilevel", high / low, poisson > 0.4 ? 120 : 60);
    }
  }
}

// Held at one end, to the coarse levels too: free there, it would answer to a push with a flight.
TEST(Multilevel, ConditionNumberOfAHeldBarHardlyDependsOnStiffness) {
  const auto device = open_double();
  for (const double young : {1e5, 1e7, 1e9}) {
    Stage stage = stage_of(lattice(12, 2, 2, spacing), young, 0.3);
    stage.hold([](const Vector3& x) { return x.x() < 1.5 * spacing; });
    SolveRig rig(*device, stage.scene, stage.model);
    const LawConstants& law = stage.model.constants[0];
    const auto [low, high] = spectrum(rig, stage, (1 + 0.15 * law.coupling) / law.bound);
    expect_below("held, E " + std::to_string(int(young / 1e3)) + " kPa: condition", high / low, 60);
  }
}

// One application takes most of a smooth error away: bending and stretching of a bar.
TEST(Multilevel, SmoothErrorsFall) {
  const auto device = open_double();
  Stage stage = stage_of(lattice(16, 4, 4, spacing), 1e9, 0.3);
  const std::size_t n = stage.model.count();
  SolveRig rig(*device, stage.scene, stage.model);
  rig.forces(std::vector<Vector3>(n, Vector3::Zero()));
  rig.refresh();
  const double length = 1.6, middle = stage.model.position[0].x() + 0.75;
  for (const bool bending : {false, true}) {
    std::vector<Vector3> v;
    for (const Vector3& x : stage.model.position) {
      const double s = (x.x() - middle) / length * 2 * M_PI;
      const double y = x.y() - stage.model.position[0].y() - 0.15;
      v.push_back(bending ? Vector3(y * std::sin(s) * 2 * M_PI / length, std::cos(s), 0)
                          : Vector3(std::sin(s), 0, 0));
    }
    // Of what the derivative makes of v, P^-1 gives back s v and a rest; in the derivative's norm.
    const std::vector<Vector3> hv = rig.product(v), back = rig.precondition(hv, 0.6),
                               rest = plus(v, -1, back);
    const double size = inner(v, hv), left = inner(rest, rig.product(rest));
    expect_below(std::string(bending ? "bending" : "stretching") + ": energy of what is left", left / size,
                 0.5);
  }
}

} // namespace
} // namespace pliant::test
