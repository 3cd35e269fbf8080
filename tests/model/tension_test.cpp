// A bar pulled at its ends returns the Young's modulus and Poisson's ratio that were typed in.
#include "tests/model/lattice.h"

#include <Eigen/Geometry>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace pliant {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

void add_block(Triplets& triplets, std::uint32_t i, std::uint32_t j, double value) {
  for (int axis = 0; axis < 3; ++axis) triplets.emplace_back(3 * i + axis, 3 * j + axis, value);
}

/// Second derivative of the corotated energy at rest. With N = xi / x, du the difference along a bond, <> the
/// weighted average, a = <N x du / x>, G = I - <N N> (of trace 1) and the rotation eliminated:
///   energy density = mu (<|du|^2 / x^2> - a . G^-1 a) + kappa <N . du / x>^2
Sparse rest_hessian(const Model& model) {
  const LawConstants& c = model.constants[0];
  Triplets springs, states;
  std::vector<double> scale;
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    const double factor = c.modulus * model.volume[i]; // 2 mu V
    const Matrix3 g_inverse = (Matrix3::Identity() - test::second_moment(model, i)).inverse();
    const Matrix3 root = g_inverse.llt().matrixL().transpose(); // root^T root = G^-1
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model.bonds.neighbour[b];
      const Vector3 xi = model.reference[j] - model.reference[i], n = xi.normalized();
      const double w = model.bonds.weight[b], x = xi.norm();
      const double stiffness = factor * w / (x * x);
      add_block(springs, i, i, stiffness);
      add_block(springs, j, j, stiffness);
      add_block(springs, i, j, -stiffness);
      add_block(springs, j, i, -stiffness);
      Matrix3 cross;
      cross << 0, -n.z(), n.y(), n.z(), 0, -n.x(), -n.y(), n.x(), 0;
      Eigen::Matrix<double, 4, 3> state;
      state << root * cross, n.transpose();
      state *= w / x;
      for (int row = 0; row < 4; ++row)
        for (int axis = 0; axis < 3; ++axis) {
          states.emplace_back(4 * i + row, 3 * j + axis, state(row, axis));
          states.emplace_back(4 * i + row, 3 * i + axis, -state(row, axis));
        }
    }
    scale.insert(scale.end(), {-factor, -factor, -factor, factor * c.coupling});
  }
  const auto unknowns = static_cast<Eigen::Index>(3 * model.count()),
             rows = static_cast<Eigen::Index>(scale.size());
  Sparse hessian(unknowns, unknowns), state(rows, unknowns);
  hessian.setFromTriplets(springs.begin(), springs.end());
  state.setFromTriplets(states.begin(), states.end());
  const Sparse scaled = Eigen::Map<const Eigen::VectorXd>(scale.data(), rows).asDiagonal() * state;
  return hessian + Sparse(state.transpose() * scaled);
}

struct Measured {
  double young = 0, poisson = 0;
};

/// A bar of length * layers * layers particles, its end layers moved apart along x and free across.
Measured pull(int length, int layers, double horizon, double young, double poisson) {
  const double spacing = 0.1;
  Model model = assemble_points(test::block(length, layers, layers, spacing), spacing, horizon,
                                test::material("corotated", young, poisson), spacing * spacing * spacing);
  const Sparse hessian = rest_hessian(model);
  const double low = model.position.front().x(), high = low + (length - 1) * spacing, strain = 1e-3;
  const auto at_end = [&](std::size_t i) {
    const double x = model.position[i].x();
    return x < low + spacing / 2 || x > high - spacing / 2;
  };
  const Eigen::Index unknowns = hessian.rows();
  Eigen::VectorXd given = Eigen::VectorXd::Zero(unknowns), free = Eigen::VectorXd::Ones(unknowns);
  for (std::size_t i = 0; i < model.count(); ++i)
    if (at_end(i)) {
      given[static_cast<Eigen::Index>(3 * i)] = strain * (model.position[i].x() - low);
      free[static_cast<Eigen::Index>(3 * i)] = 0;
    }
  // Free rows and columns of the matrix; ones on the diagonal of the rest. Rigid motion across is left to the
  // conjugate gradients, which never enter the null space.
  const Sparse ones = Sparse(Eigen::VectorXd(Eigen::VectorXd::Ones(unknowns) - free).asDiagonal());
  const Sparse reduced = Sparse(free.asDiagonal() * hessian * free.asDiagonal()) + ones;
  Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper> solver(reduced);
  solver.setTolerance(1e-8);
  solver.setMaxIterations(4000);
  Eigen::VectorXd u = solver.solve(Eigen::VectorXd(free.asDiagonal() * (hessian * -given)));
  EXPECT_EQ(solver.info(), Eigen::Success);
  u += given;
  const Eigen::VectorXd force = hessian * u;

  Measured answer;
  double pulled = 0, near = 0, far = 0, across = 0, square = 0;
  int near_count = 0, far_count = 0;
  const Vector3 centre = (model.position.front() + model.position.back()) / 2;
  for (std::size_t i = 0; i < model.count(); ++i) {
    const Vector3 p = model.position[i] - centre;
    const auto at = static_cast<Eigen::Index>(3 * i);
    if (p.x() > (length - 1.5) * spacing / 2) pulled += force[at];
    if (std::abs(p.x() + 4.5 * spacing) < 0.1 * spacing) near += u[at], ++near_count;
    if (std::abs(p.x() - 4.5 * spacing) < 0.1 * spacing) far += u[at], ++far_count;
    if (std::abs(p.x()) < 3 * spacing) {
      across += p.y() * u[at + 1];
      square += p.y() * p.y();
    }
  }
  const double along = (far / far_count - near / near_count) / (9 * spacing);
  answer.young = pulled / (layers * spacing * layers * spacing) / along;
  answer.poisson = -across / square / along;
  return answer;
}

TEST(Tension, ReturnsYoungsModulusAndPoissonsRatio) {
  for (const int layers : {3, 5})
    for (const double poisson : {0.0, 0.25, 0.4}) {
      const Measured bar = pull(30, layers, 1.87, 2e5, poisson);
      EXPECT_NEAR(bar.young / 2e5, 1, 0.002) << layers << " layers, ratio " << poisson;
      EXPECT_NEAR(bar.poisson, poisson, 0.002) << layers << " layers, ratio " << poisson;
      std::printf("%d layers, ratio %.2f: E / E0 = %.9f, ratio %.9f\n", layers, poisson, bar.young / 2e5,
                  bar.poisson);
    }
}

} // namespace
} // namespace pliant
