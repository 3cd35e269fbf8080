// ordinary_energy: 1/2 sum c (y - x)^2 + V (a - b)(theta - 1)^2.
#include "kernels/ordinary_energy.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(OrdinaryEnergy);

constexpr double limit = 3; // y - x is wrong by one and a half roundings of both, twice in a square; 0.4 seen

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size) : p("ordinary", size, kernel_seed + 10, true) {
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(2);
    in["energy"] = p.buffer(1, sentinel);
    Expected energy(in["energy"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      double stretching = 0, size_stretching = 0, dilatation = 0, size_dilatation = 0;
      for (const auto& bond : p.bonds[i]) {
        const double x = bond.reference.norm(), y = p.current(i, bond).norm();
        stretching += bond.out * (y - x) * (y - x);
        size_stretching += bond.out * std::abs(y - x) * (y + x);
        dilatation += p.inverse_modulus[i] * bond.out * x * (y - x);
        size_dilatation += p.inverse_modulus[i] * bond.out * x * (y + x);
      }
      const double volumetric = p.bonds[i].empty() ? 0 : p.coupling[i] / p.inverse_modulus[i];
      energy.set(p.first + i, (stretching + volumetric * dilatation * dilatation) / 2,
                 size_stretching + std::abs(volumetric * dilatation) * size_dilatation);
    }
    wanted = {{"energy", energy}};
  }
};

TEST_P(OrdinaryEnergy, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::ordinary_energy::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                  limit);
  }
}

TEST_P(OrdinaryEnergy, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::ordinary_energy::Args>(GetParam(), Problem(129), {"position", 4, 2},
                                                       {"energy", 1});
}

} // namespace
} // namespace pliant::test
