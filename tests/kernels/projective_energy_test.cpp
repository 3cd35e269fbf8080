// projective_energy: 1/2 sum c (d (|F xi| - x)^2 + (1 - d)(|Y| - x)^2).
#include "kernels/projective_energy.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(ProjectiveEnergy);

// A length l is wrong by at most three epsilon (a driver's sqrt by two), so (l - x)^2 / 2 by 3 l |l - x|,
// which is 1.5 of the scale's |l - x| (l + x) where l is x; the products and the sum add half. 0.2 seen.
constexpr double limit = 2;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size) : p("projective", size, kernel_seed + 14) {
    Random random(kernel_seed + 15);
    constexpr double d = 0.625;
    in = p.bond_values;
    in["deviatoric"] = {d};
    in["position"] = p.vectors(p.position);
    in["record"] = p.buffer(12, not_a_number);
    in["energy"] = p.buffer(1, sentinel);
    Expected energy(in["energy"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      const Matrix3 f = (Matrix3() << random.vector(), random.vector(), random.vector()).finished();
      for (std::size_t k = 0; k < 12; ++k)
        in["record"][12 * (p.first + i) + k] = k % 4 < 3 ? f(static_cast<int>(k / 4), static_cast<int>(k % 4))
                                                         : p.displacement[i][static_cast<int>(k / 4)];
      double sum = 0, size_sum = 0;
      for (const auto& bond : p.bonds[i]) {
        const double x = bond.reference.norm();
        const double affine = (f * bond.reference).norm(), direct = p.current(i, bond).norm();
        sum += bond.out * (d * std::pow(affine - x, 2) + (1 - d) * std::pow(direct - x, 2)) / 2;
        size_sum += bond.out * (d * std::abs(affine - x) * (f.norm() + 1) * x +
                                (1 - d) * std::abs(direct - x) * (direct + x));
      }
      energy.set(p.first + i, sum, size_sum);
    }
    wanted = {{"energy", energy}};
  }
};

TEST_P(ProjectiveEnergy, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::projective_energy::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                    limit);
  }
}

TEST_P(ProjectiveEnergy, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::projective_energy::Args>(GetParam(), Problem(129), {"position", 4, 0},
                                                         {"energy", 1});
}

} // namespace
} // namespace pliant::test
