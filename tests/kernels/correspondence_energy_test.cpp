// correspondence_energy: mu V / 2 (|F|^2 - 3) - mu V (J - 1) + lambda V / 2 (J - 1)^2 + 1/2 sum c |Y - F xi|^2, with K^-1 that
// of the bonds: where it is not, the last term is no square.
#include "kernels/correspondence_energy.h"
#include "tests/support/kernel_tensors.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(CorrespondenceEnergy);

// Y - R xi is wrong by two roundings of its terms, twice in a square, and again through F; 2 seen.
constexpr double limit = 20;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t particles) : p("corotated", particles, kernel_seed + 25) {
    Random random(kernel_seed + 26);
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(17);
    in["rotation"] = p.buffer(4, not_a_number);
    in["energy"] = p.buffer(1, sentinel);
    Expected energy(in["energy"]);
    for (std::size_t i = 0; i < p.count; ++i) expect(random, energy, i);
    wanted = {{"energy", energy}};
  }

  void expect(Random& random, Expected& energy, std::size_t i) {
    Matrix3 yx = Matrix3::Zero(), xx = Matrix3::Zero();
    for (const auto& bond : p.bonds[i]) {
      yx += bond.out * p.current(i, bond) * bond.reference.transpose();
      xx += bond.out * bond.reference * bond.reference.transpose();
    }
    // K^-1 of these bonds, or of some where they do not span space; rounded, which the formula must not feel.
    const Matrix3 k = p.inverse_modulus[i] * xx;
    const Eigen::JacobiSVD<Matrix3> svd(k, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const bool full = svd.singularValues()[2] > 0.05 * svd.singularValues()[0];
    const Matrix3 wanted_inverse = full ? Matrix3(k.inverse()) : Matrix3(3 * Matrix3::Identity());
    constexpr int row_of[] = {0, 0, 0, 1, 1, 2}, column_of[] = {0, 1, 2, 1, 2, 2};
    for (std::size_t r = 0; r < 6; ++r)
      in["shape"][(r + 11) * p.total + p.first + i] = rounded(wanted_inverse(row_of[r], column_of[r]));
    const Matrix3 inverse = symmetric_at(in["shape"], p, i, 11);
    Eigen::Quaterniond q = full ? Eigen::Quaterniond(Polar(yx).rotation) : random.rotation();
    for (double& value : q.coeffs()) value = rounded(value);
    for (std::size_t c = 0; c < 4; ++c) in["rotation"][4 * (p.first + i) + c] = q.coeffs()[static_cast<int>(c)];
    if (p.bonds[i].empty()) {
      energy.set(p.first + i, 0, 1);
      return;
    }
    if (!full) {
      energy.set(p.first + i, 0, anything);
      return;
    }
    const double stiffness = 1 + p.coupling[i] / 1.5, mu_v = 1 / (3 * p.inverse_modulus[i]);
    const Matrix3 f = p.inverse_modulus[i] * yx * inverse;
    const double growth = f.determinant() - 1;
    double value = mu_v * ((f.squaredNorm() - 3) / 2 - growth + stiffness / 2 * growth * growth);
    double size = mu_v * (f.squaredNorm() + std::abs(growth) + 3 + stiffness * std::abs(growth) *
                          (1 + std::pow(f.norm(), 3))) * inverse.norm();
    for (const auto& bond : p.bonds[i]) {
      const Vector3 y = p.current(i, bond);
      value += bond.out * (y - f * bond.reference).squaredNorm() / 2;
      size += bond.out * y.norm() * (y.norm() + bond.reference.norm()) * inverse.norm();
    }
    energy.set(p.first + i, value, size);
  }
};

TEST_P(CorrespondenceEnergy, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::correspondence_energy::Args>(GetParam(), problem.p.count, problem.in,
                                                        problem.wanted, limit);
  }
}

TEST_P(CorrespondenceEnergy, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::correspondence_energy::Args>(GetParam(), Problem(129), {"displacement", 4, 0},
                                                             {"energy", 1});
}

TEST_P(CorrespondenceEnergy, Gated) {
  Problem problem(17);
  problem.in["gated"] = {1};
  problem.in["gate"] = {1, 0, 0, 0};
  const Values out =
      run_kernel<kernels::correspondence_energy::Args>(OpenDevices::of(GetParam()), problem.p.count, problem.in);
  EXPECT_EQ(out.at("energy"), problem.in.at("energy"));
}

} // namespace
} // namespace pliant::test
