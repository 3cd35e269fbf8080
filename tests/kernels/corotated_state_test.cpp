// corotated_state: the signed polar decomposition of S, and A = (1 - kappa / mu (theta - 1)) R.
#include "kernels/corotated_state.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(CorotatedState);

// S is good to a few roundings of its terms; the rotation amplifies them by the condition, which is in the
// scale. Newton stops when what is left is below one rounding. 3 seen.
constexpr double limit = 20;

Matrix3 matrix_of(const std::vector<double>& rotation, std::size_t i) {
  return Eigen::Quaterniond(rotation[4 * i + 3], rotation[4 * i], rotation[4 * i + 1], rotation[4 * i + 2])
      .toRotationMatrix();
}

struct Problem {
  BondProblem p;
  Values in;
  std::vector<Matrix3> s;
  std::vector<double> size; ///< sum of the magnitudes of the terms of S
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t particles, bool far_start = false)
      : p("corotated", particles, kernel_seed + 1) {
    Random random(kernel_seed + 2);
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(11);
    in["solver"] = solver_running;
    in["rotation"] = p.buffer(4, sentinel);
    in["record"] = p.buffer(12, sentinel);
    Expected record(in["record"]);
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
      start(random, i, far_start);
      expect(record, i);
    }
    Expected rotation(in["rotation"]); // its sign is free: compared as a matrix below
    for (std::size_t k = 0; k < 4 * p.count; ++k) rotation.set(4 * p.first + k, 0, anything);
    wanted = {{"rotation", rotation}, {"record", record}};
  }

  void start(Random& random, std::size_t i, bool far) {
    Eigen::Quaterniond q(Polar(s[i]).rotation);
    if (far || p.bonds[i].empty()) // of length one in float too
      q = Eigen::Quaterniond(std::copysign(0.5, random()), std::copysign(0.5, random()),
                             std::copysign(0.5, random()), std::copysign(0.5, random()));
    else
      q = q * Eigen::Quaterniond(Eigen::AngleAxisd(0.3, random.vector().normalized()));
    for (std::size_t k = 0; k < 4; ++k)
      in["rotation"][4 * (p.first + i) + k] = rounded(q.coeffs()[static_cast<int>(k)]);
  }

  void expect(Expected& record, std::size_t i) {
    const Polar polar(s[i]);
    Matrix3 r = polar.rotation;
    double theta = polar.value.sum(), error = anything;
    if (p.bonds[i].empty()) {
      r = matrix_of(in["rotation"], p.first + i);
      theta = 0;
      error = 1;
    } else if (polar.condition < anything) {
      error = polar.condition * size[i] / s[i].norm() + 1;
    }
    const double factor = 1 - p.coupling[i] * (theta - 1);
    const double size_factor = 1 + p.coupling[i] * (1 + size[i]);
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t c = 0; c < 3; ++c)
        record.set(4 * (3 * (p.first + i) + row) + c, factor * r(static_cast<int>(row), static_cast<int>(c)),
                   size_factor * error);
      record.set(4 * (3 * (p.first + i) + row) + 3, p.displacement[i][static_cast<int>(row)]);
    }
  }

  // Also where the rotation is not unique it must be one, and reach the largest trace there is.
  void expect_rotations(const Values& out, double epsilon) const {
    for (std::size_t i = 0; i < p.count; ++i) {
      const Matrix3 r = matrix_of(out.at("rotation"), p.first + i);
      EXPECT_LT((r.transpose() * r - Matrix3::Identity()).norm(), 20 * epsilon + 1e-6 * p.bonds[i].empty())
          << i;
      const Polar polar(s[i]);
      // horn_rotation's bias of 1e-5, which makes the answer unique, costs at most twice as much.
      const double allowed =
          limit * epsilon * (size[i] + s[i].norm()) + (polar.condition == anything ? 4e-5 : 0) * s[i].norm();
      EXPECT_NEAR((r.transpose() * s[i]).trace(), polar.value.sum(), allowed) << "particle " << i;
    }
  }
};

TEST_P(CorotatedState, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    const Values out = expect_kernel<kernels::corotated_state::Args>(GetParam(), problem.p.count, problem.in,
                                                                     problem.wanted, limit);
    problem.expect_rotations(out, GetParam().epsilon());
  }
}

TEST_P(CorotatedState, AnyStartLeadsThere) {
  const Problem problem(127, true);
  const Values out = expect_kernel<kernels::corotated_state::Args>(GetParam(), problem.p.count, problem.in,
                                                                   problem.wanted, limit);
  problem.expect_rotations(out, GetParam().epsilon());
}

TEST_P(CorotatedState, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::corotated_state::Args>(GetParam(), Problem(129), {"displacement", 4, 1},
                                                       {"record", 12});
}

TEST_P(CorotatedState, NothingOnceTheSolverHasStopped) {
  expect_nothing_when_stopped<kernels::corotated_state::Args>(GetParam(), Problem(17), "record");
}

} // namespace
} // namespace pliant::test
