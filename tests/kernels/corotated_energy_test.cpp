// corotated_energy: 1/2 sum c |Y - R xi|^2 + V kappa (theta - 1)^2, with theta - 1 = <(Y - R xi) . R xi> /
// x^2, which is the same where the weights of a particle sum to one.
#include "kernels/corotated_energy.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(CorotatedEnergy);

constexpr double limit = 7; // Y - R xi is wrong by two roundings of its terms, twice in a square; 1.4 seen

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size) : p("corotated", size, kernel_seed + 5) {
    Random random(kernel_seed + 6);
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(2);
    in["rotation"] = p.buffer(4, not_a_number);
    in["energy"] = p.buffer(1, sentinel);
    Expected energy(in["energy"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      Eigen::Quaterniond q = random.rotation();
      for (double& value : q.coeffs()) value = rounded(value);
      for (std::size_t k = 0; k < 4; ++k)
        in["rotation"][4 * (p.first + i) + k] = q.coeffs()[static_cast<int>(k)];
      const Matrix3 r = q.toRotationMatrix();
      double deviation = 0, size_deviation = 0, dilatation = 0, size_dilatation = 0;
      for (const auto& bond : p.bonds[i]) {
        const Vector3 y = p.current(i, bond), target = r * bond.reference, off = y - target;
        const double size_off = y.norm() + target.norm();
        deviation += bond.out * off.squaredNorm();
        size_deviation += bond.out * off.norm() * size_off;
        dilatation += p.inverse_modulus[i] * bond.out * off.dot(target);
        size_dilatation += p.inverse_modulus[i] * bond.out * size_off * target.norm();
      }
      const double volumetric = p.bonds[i].empty() ? 0 : p.coupling[i] / p.inverse_modulus[i];
      energy.set(p.first + i, (deviation + volumetric * dilatation * dilatation) / 2,
                 size_deviation + volumetric * std::abs(dilatation) * size_dilatation);
    }
    wanted = {{"energy", energy}};
  }
};

TEST_P(CorotatedEnergy, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::corotated_energy::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                   limit);
  }
}

TEST_P(CorotatedEnergy, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::corotated_energy::Args>(GetParam(), Problem(129), {"displacement", 4, 0},
                                                        {"energy", 1});
}

} // namespace
} // namespace pliant::test
