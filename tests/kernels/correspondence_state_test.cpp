// correspondence_state: F = S K^-1 with S of the range, A = F - (F + s cof F) K^-1 / 3 with s = (lambda /
// mu)(J - 1) - 1, and the rotation nearest to F.
#include "kernels/correspondence_state.h"
#include "tests/support/kernel_tensors.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(CorrespondenceState);

// Sums of up to 26 products, then a cofactor and two products of matrices, whose sizes are in the scale; 2
// seen.
constexpr double limit = 25;

struct Problem {
  BondProblem p;
  Values in;
  std::vector<Matrix3> f;
  std::vector<double> size; ///< of the terms of F
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t particles) : p("corotated", particles, kernel_seed + 21) {
    Random random(kernel_seed + 22);
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(17);
    in["solver"] = solver_running;
    in["rotation"] = p.buffer(4, sentinel);
    in["record"] = p.buffer(12, sentinel);
    Expected record(in["record"]), rotation(in["rotation"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      gradient(random, i);
      Eigen::Quaterniond q(Polar(f[i]).rotation);
      q = q * Eigen::Quaterniond(Eigen::AngleAxisd(0.3, random.vector().normalized()));
      for (std::size_t k = 0; k < 4; ++k) {
        in["rotation"][4 * (p.first + i) + k] = rounded(q.coeffs()[static_cast<int>(k)]);
        rotation.set(4 * (p.first + i) + k, 0, anything); // its sign is free: compared as a matrix below
      }
      expect(record, i);
    }
    wanted = {{"rotation", rotation}, {"record", record}};
  }

  void gradient(Random& random, std::size_t i) {
    Matrix3 sum = Matrix3::Zero();
    double terms = 0;
    for (const auto& bond : p.bonds[i]) {
      const Vector3 y = p.position[bond.to] - p.position[i], u = p.displacement[bond.to] - p.displacement[i];
      sum += bond.out * y * bond.reference.transpose();
      terms += bond.out * (y.norm() + u.norm()) * bond.reference.norm();
    }
    for (int k = 0; k < 9; ++k) {
      double& value = in["shape"][static_cast<std::size_t>(k + 2) * p.total + p.first + i];
      sum(k / 3, k % 3) = value = rounded(sum(k / 3, k % 3));
    }
    for (const auto& bond : p.bonds[i])
      sum += bond.out * (p.displacement[bond.to] - p.displacement[i]) * bond.reference.transpose();
    const Matrix3 inverse = symmetric_rows(in["shape"], random, p, i, 11);
    f.push_back(p.inverse_modulus[i] * sum * inverse);
    size.push_back(p.inverse_modulus[i] * terms * inverse.norm());
  }

  void expect(Expected& record, std::size_t i) {
    const Matrix3 inverse = symmetric_at(in["shape"], p, i, 11);
    const double stiffness = 1 + p.coupling[i] / 1.5, norm = f[i].norm(), error = size[i];
    const double pressure = stiffness * (f[i].determinant() - 1) - 1;
    const Matrix3 cof = cofactor_of(f[i]), a = f[i] - (f[i] + pressure * cof) * inverse / 3;
    const double off_pressure = stiffness * (norm * norm * error + norm * norm * norm + 1) + 1;
    const double off =
        error +
        (error + std::abs(pressure) * norm * (error + norm) + off_pressure * cof.norm()) * inverse.norm() / 3;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t c = 0; c < 3; ++c)
        record.set(4 * (3 * (p.first + i) + row) + c, a(static_cast<int>(row), static_cast<int>(c)), off);
      record.set(4 * (3 * (p.first + i) + row) + 3, p.displacement[i][static_cast<int>(row)]);
    }
  }
};

TEST_P(CorrespondenceState, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    const BondProblem& p = problem.p;
    const Values out = expect_kernel<kernels::correspondence_state::Args>(GetParam(), p.count, problem.in,
                                                                          problem.wanted, limit);
    for (std::size_t i = 0; i < p.count; ++i) {
      const double* q = out.at("rotation").data() + 4 * (p.first + i);
      const Matrix3 r = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix();
      if (p.bonds[i].empty()) continue;
      EXPECT_LT((r.transpose() * r - Matrix3::Identity()).norm(), 20 * GetParam().epsilon()) << i;
      const Polar polar(problem.f[i]);
      // horn_rotation's bias of 1e-5, which makes the answer unique, costs at most twice as much.
      const double allowed = limit * GetParam().epsilon() * (problem.size[i] + problem.f[i].norm()) +
                             (polar.condition == anything ? 4e-5 : 0) * problem.f[i].norm();
      EXPECT_NEAR((r.transpose() * problem.f[i]).trace(), polar.value.sum(), allowed) << "particle " << i;
    }
  }
}

TEST_P(CorrespondenceState, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::correspondence_state::Args>(GetParam(), Problem(129), {"displacement", 4, 1},
                                                            {"record", 12});
}

TEST_P(CorrespondenceState, NothingOnceTheSolverHasStopped) {
  expect_nothing_when_stopped<kernels::correspondence_state::Args>(GetParam(), Problem(17), "record");
}

} // namespace
} // namespace pliant::test
