// projective_state: F = (sum c x^2 Y (x) xi) K^-1, its signed singular values clamped at 0.1, or its rows
// swapped.
#include "kernels/projective_state.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(ProjectiveState);

// Sums of up to 26 products, times the inverse of a shape tensor, whose condition is in the scale; 2 seen.
constexpr double limit = 25;
constexpr double least = 0.1;

struct Problem {
  BondProblem p;
  Values in;
  std::vector<Matrix3> f;   ///< before its inversion is prevented
  std::vector<double> size; ///< sum of the magnitudes of the terms of F
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t particles, bool swap = false) : p("projective", particles, kernel_seed + 11) {
    for (std::size_t i = 0; i < p.count; i += 3) // every third particle sees a mirror image
      p.displacement[i].y() = rounded(p.displacement[i].y() + 1.5 * p.spacing);
    in = p.bond_values;
    in["swap_rows"] = {double(swap)};
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(8);
    in["solver"] = solver_running;
    in["record"] = p.buffer(12, sentinel);
    Expected record(in["record"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      gradient(i);
      expect(record, i, swap);
    }
    wanted = {{"record", record}};
  }

  void gradient(std::size_t i) {
    Matrix3 yx = Matrix3::Zero(), xx = Matrix3::Zero();
    double terms = 0;
    for (const auto& bond : p.bonds[i]) {
      const double weight = bond.out * bond.reference.squaredNorm();
      yx += weight * p.current(i, bond) * bond.reference.transpose();
      xx += weight * bond.reference * bond.reference.transpose();
      terms += weight * p.current(i, bond).norm() * bond.reference.norm();
    }
    const Eigen::JacobiSVD<Matrix3> svd(xx, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Vector3 inverse = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      if (svd.singularValues()[k] > 1e-3 * svd.singularValues()[0]) inverse[k] = 1 / svd.singularValues()[k];
    Matrix3 k = svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose();
    constexpr int row_of[] = {0, 0, 0, 1, 1, 2}, column_of[] = {0, 1, 2, 1, 2, 2};
    for (std::size_t r = 0; r < 6; ++r) {
      const double value = rounded((k(row_of[r], column_of[r]) + k(column_of[r], row_of[r])) / 2);
      k(row_of[r], column_of[r]) = k(column_of[r], row_of[r]) = value;
      in["shape"][(r + 2) * p.total + p.first + i] = value;
    }
    f.push_back(yx * k);
    size.push_back(terms * k.norm());
  }

  void expect(Expected& record, std::size_t i, bool swap) {
    Matrix3 result = f[i];
    double error = size[i];
    if (swap) {
      const double determinant = result.determinant();
      if (determinant < 0) result.row(0).swap(result.row(1));
      if (std::abs(determinant) < 1e-4 * std::pow(size[i], 3))
        error = anything; // its sign is a matter of rounding
    } else {
      const Polar polar(f[i]);
      if (polar.value[2] < least) {
        result = polar.u * polar.value.cwiseMax(least).asDiagonal() * polar.v.transpose();
        error = polar.condition == anything ? anything : polar.condition * (size[i] + 0.1);
      }
    }
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t c = 0; c < 3; ++c)
        record.set(4 * (3 * (p.first + i) + row) + c, result(static_cast<int>(row), static_cast<int>(c)),
                   error);
      record.set(4 * (3 * (p.first + i) + row) + 3, p.displacement[i][static_cast<int>(row)]);
    }
  }
};

TEST_P(ProjectiveState, ClampsSingularValues) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    const Values out = expect_kernel<kernels::projective_state::Args>(GetParam(), problem.p.count, problem.in,
                                                                      problem.wanted, limit);
    std::size_t clamped = 0;
    for (std::size_t i = 0; i < problem.p.count; ++i) {
      Matrix3 result;
      for (std::size_t k = 0; k < 9; ++k)
        result(static_cast<int>(k / 3), static_cast<int>(k % 3)) =
            out.at("record")[12 * (problem.p.first + i) + 4 * (k / 3) + k % 3];
      const Polar before(problem.f[i]), after(result);
      const double error = 100 * GetParam().epsilon() * (1 + problem.size[i]);
      EXPECT_GE(after.value[2], least - error) << "particle " << i;
      for (int k = 0; k < 2; ++k)
        EXPECT_NEAR(after.value[k], std::max(before.value[k], least), error) << "particle " << i;
      clamped += before.value[2] < least;
    }
    if (size >= 127) {
      EXPECT_GT(clamped, size / 40);
    }
  }
}

TEST_P(ProjectiveState, SwapsRows) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size, true);
    expect_kernel<kernels::projective_state::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                   limit);
  }
}

TEST_P(ProjectiveState, NotANumberReachesNeighboursOnly) {
  for (const bool swap : {false, true})
    expect_nan_contained<kernels::projective_state::Args>(GetParam(), Problem(129, swap),
                                                          {"displacement", 4, 2}, {"record", 12});
}

TEST_P(ProjectiveState, NothingOnceTheSolverHasStopped) {
  expect_nothing_when_stopped<kernels::projective_state::Args>(GetParam(), Problem(17), "record");
}

} // namespace
} // namespace pliant::test
