// bond_rotation: the signed polar decomposition of <Y (x) xi / x^2> at y_n + u.
#include "kernels/bond_rotation.h"
#include "shaders/common/solver.glsl"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(BondRotation);

// As of corotated_state: a few roundings of the terms of S.
constexpr double limit = 20;

struct Problem {
  BondProblem p;
  Values in;
  std::vector<Matrix3> s;
  std::vector<double> size; ///< sum of the magnitudes of the terms of S
  explicit Problem(std::size_t particles) : p("ordinary", particles, kernel_seed + 70) {
    Random random(kernel_seed + 71);
    in = p.bond_values;
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(2);
    in["rotation"] = p.buffer(4, sentinel);
    in["solver"] = std::vector<double>(SOLVER_ENTRIES, 0.0);
    in["solver"][SOLVER_TAKEN] = in["solver"][SOLVER_LINEAR] = 1;
    for (std::size_t i = 0; i < p.count; ++i) {
      Matrix3 sum = Matrix3::Zero();
      double terms = 0;
      for (const auto& bond : p.bonds[i]) {
        sum += bond.out * p.current(i, bond) * bond.reference.transpose();
        terms += bond.out * (p.position[bond.to].norm() + p.position[i].norm()) * bond.reference.norm();
      }
      s.push_back(p.inverse_modulus[i] * sum);
      size.push_back(p.inverse_modulus[i] * terms);
      Eigen::Quaterniond q = p.bonds[i].empty() ? Eigen::Quaterniond(0.5, 0.5, 0.5, -0.5)
                                                : Eigen::Quaterniond(Polar(s[i]).rotation);
      if (!p.bonds[i].empty())
        q = q * Eigen::Quaterniond(Eigen::AngleAxisd(0.3, random.vector().normalized()));
      for (std::size_t k = 0; k < 4; ++k)
        in["rotation"][4 * (p.first + i) + k] = rounded(q.coeffs()[static_cast<int>(k)]);
    }
  }
};

TEST_P(BondRotation, LargestTrace) {
  for (const std::size_t particles : awkward_sizes) {
    const Problem problem(particles);
    const BondProblem& p = problem.p;
    Expected rotation(problem.in.at("rotation")); // its sign is free: compared as a matrix below
    for (std::size_t k = 0; k < 4 * p.count; ++k) rotation.set(4 * p.first + k, 0, anything);
    const Values out = expect_kernel<kernels::bond_rotation::Args>(GetParam(), p.count, problem.in,
                                                                   {{"rotation", rotation}}, limit);
    const double epsilon = GetParam().epsilon();
    for (std::size_t i = 0; i < p.count; ++i) {
      const double* q = &out.at("rotation")[4 * (p.first + i)];
      const Matrix3 r = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix(), &s = problem.s[i];
      EXPECT_LT((r.transpose() * r - Matrix3::Identity()).norm(), 20 * epsilon + 1e-6 * p.bonds[i].empty())
          << i;
      const Polar polar(s);
      // horn_rotation's bias of 1e-5, which makes the answer unique, costs at most twice as much.
      const double allowed = limit * epsilon * (problem.size[i] + s.norm()) +
                             (polar.condition == anything ? 4e-5 : 0) * s.norm();
      EXPECT_NEAR((r.transpose() * s).trace(), polar.value.sum(), allowed) << "particle " << i;
    }
  }
}

TEST_P(BondRotation, StaysWhereNoDirectionIsSought) {
  for (const int entry : {SOLVER_TAKEN, SOLVER_LINEAR}) {
    Problem problem(129);
    problem.in["solver"][static_cast<std::size_t>(entry)] = 0;
    const Values out =
        run_kernel<kernels::bond_rotation::Args>(OpenDevices::of(GetParam()), problem.p.count, problem.in);
    EXPECT_EQ(out.at("rotation"), problem.in["rotation"]);
  }
}

} // namespace
} // namespace pliant::test
