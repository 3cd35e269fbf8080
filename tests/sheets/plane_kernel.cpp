// corotated_state with `plane`: the rotation about z in closed form; corotated_tangent with `flat`: what it
// keeps eigenvalues above.
#include "kernels/corotated_state.h"
#include "kernels/corotated_tangent.h"
#include "shaders/common/solver.glsl"
#include "tests/support/kernel_bonds.h"

#include <Eigen/Eigenvalues>

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(PlaneKernel);

/// A neighbourhood problem laid flat: nothing has a z.
struct PlaneProblem {
  BondProblem p;
  Values in;
  std::vector<Matrix3> s;
  std::vector<double> size;

  PlaneProblem(std::size_t particles, bool mirrored) : p("corotated", particles, kernel_seed + 31) {
    in = p.bond_values;
    for (auto* points : {&p.position, &p.displacement})
      for (Vector3& x : *points) {
        x.z() = 0;
        if (mirrored) x.x() = -x.x();
      }
    in["stride"] = {double(p.total)};
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(11);
    in["solver"] = std::vector<double>(SOLVER_ENTRIES, 0.0);
    in["plane"] = {1};
    in["rotation"] = p.rows(sentinel, 4, [](std::size_t, std::size_t k) { return k == 3 ? 1.0 : 0.0; });
    in["record"] = p.buffer(12, sentinel);
    for (std::size_t i = 0; i < p.count; ++i) {
      Matrix3 sum = Matrix3::Zero();
      double terms = 0;
      for (const auto& bond : p.bonds[i]) {
        const Vector3 y = p.position[bond.to] - p.position[i],
                      u = p.displacement[bond.to] - p.displacement[i];
        sum += bond.out * y * bond.reference.transpose();
        terms += bond.out * (y.norm() + u.norm()) * bond.reference.norm();
      }
      for (int k = 0; k < 9; ++k) {
        double& value = in["shape"][static_cast<std::size_t>(k + 2) * p.total + p.first + i];
        sum(k / 3, k % 3) = value = rounded(sum(k / 3, k % 3));
      }
      for (const auto& bond : p.bonds[i])
        sum += bond.out * (p.displacement[bond.to] - p.displacement[i]) * bond.reference.transpose();
      s.push_back(p.inverse_modulus[i] * sum);
      size.push_back(p.inverse_modulus[i] * terms);
    }
  }
};

// The angle is good to the rounding of S over |tr, axl|; 20 roundings as for the rotation in space.
TEST_P(PlaneKernel, TurnsAboutZ) {
  for (const bool mirrored : {false, true}) {
    PlaneProblem problem(129, mirrored);
    const BondProblem& p = problem.p;
    const Values out =
        run_kernel<kernels::corotated_state::Args>(OpenDevices::of(GetParam()), p.count, problem.in);
    for (std::size_t i = 0; i < p.count; ++i) {
      const double* q = &out.at("rotation")[4 * (p.first + i)];
      EXPECT_EQ(q[0], 0) << i;
      EXPECT_EQ(q[1], 0) << i;
      const Matrix3& s = problem.s[i];
      const double along = s(0, 0) + s(1, 1), across = s(1, 0) - s(0, 1), length = std::hypot(along, across);
      if (length < 1e-3 * problem.size[i] || p.bonds[i].empty()) continue;
      const double tolerance = 20 * GetParam().epsilon() * problem.size[i] / length;
      EXPECT_NEAR(1 - 2 * q[2] * q[2], along / length, tolerance) << i;
      EXPECT_NEAR(2 * q[2] * q[3], across / length, tolerance) << i;
      const double scale = 1 - p.coupling[i] * (length - 1); // theta = R : S
      for (std::size_t r = 0; r < 2; ++r) {
        const double* row = &out.at("record")[4 * (3 * (p.first + i) + r)];
        const double size = (1 + p.coupling[i] * (1 + problem.size[i]));
        EXPECT_NEAR(row[r], scale * along / length, size * tolerance + 20 * GetParam().epsilon() * size) << i;
        EXPECT_NEAR(row[1 - r], (r == 0 ? -1 : 1) * scale * across / length,
                    size * tolerance + 20 * GetParam().epsilon() * size)
            << i;
      }
    }
  }
}

// A point has no rotation of its own: it keeps the one before.
TEST_P(PlaneKernel, KeepsTheLastWhereThereIsNone) {
  PlaneProblem problem(17, false);
  const BondProblem& p = problem.p;
  for (std::size_t i = 0; i < p.count; ++i)
    for (std::size_t k = 0; k < 9; ++k) problem.in["shape"][(k + 2) * p.total + p.first + i] = 0;
  for (double& u : problem.in["displacement"]) u = 0;
  for (std::size_t i = 0; i < p.count; ++i) {
    problem.in["rotation"][4 * (p.first + i) + 2] = 0.6;
    problem.in["rotation"][4 * (p.first + i) + 3] = rounded(0.8);
  }
  const Values out =
      run_kernel<kernels::corotated_state::Args>(OpenDevices::of(GetParam()), p.count, problem.in);
  for (std::size_t i = 0; i < p.count; ++i) {
    EXPECT_NEAR(out.at("rotation")[4 * (p.first + i) + 2], 0.6, 1e-7);
    EXPECT_NEAR(out.at("rotation")[4 * (p.first + i) + 3], 0.8, 1e-7);
  }
}

// Kept from indefinite, no eigenvalue of the matrix lies below the scale of R, two thirds of it where nothing
// is flat.
TEST_P(PlaneKernel, TheConvexDerivativeOfFlatNeighbourhoodsIsHeldHigher) {
  PlaneProblem problem(129, false);
  const BondProblem& p = problem.p;
  Values in = problem.in;
  in.erase("plane"), in.erase("record");
  in["solver"][SOLVER_TAKEN] = in["solver"][SOLVER_LINEAR] = in["solver"][SOLVER_CONVEX] = 1;
  in["tangent"] = p.buffer(16, sentinel);
  for (const bool flat : {false, true}) {
    in["flat"] = {double(flat)};
    const Values out = run_kernel<kernels::corotated_tangent::Args>(OpenDevices::of(GetParam()), p.count, in);
    double closest = 1e300;
    for (std::size_t i = 0; i < p.count; ++i) {
      if (p.bonds[i].size() < 3) continue;
      const double *a = &out.at("tangent")[16 * (p.first + i) + 4], *b = a + 4;
      Matrix3 inverse;
      inverse << a[0], a[1], a[2], a[1], a[3], b[0], a[2], b[0], b[1];
      const double least = 1 / Eigen::SelfAdjointEigenSolver<Matrix3>(inverse).eigenvalues()[2];
      const double held = std::max(0.02, flat ? b[2] : b[2] * 2 / 3);
      EXPECT_GT(least, held * (1 - 1e-3)) << i;
      closest = std::min(closest, least / held);
    }
    EXPECT_NEAR(closest, 1, 2e-3); // some were held there
  }
}

} // namespace
} // namespace pliant::test
