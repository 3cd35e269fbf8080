// ordinary_state: phi = ((a - b) / b)(theta - 1), with theta - 1 = <(y - x) / x>.
#include "kernels/ordinary_state.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(OrdinaryState);

constexpr double limit = 2; // y - x is wrong by one and a half roundings of both; 0.25 seen

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size) : p("ordinary", size, kernel_seed + 7, true) {
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(2);
    in["solver"] = solver_running;
    in["extension"] = p.buffer(4, sentinel);
    Expected extension(in["extension"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      double sum = 0, size_sum = 0;
      for (const auto& bond : p.bonds[i]) {
        const double x = bond.reference.norm(), y = p.current(i, bond).norm();
        sum += bond.out * x * (y - x);
        size_sum += bond.out * x * (y + x);
      }
      const double factor = p.coupling[i] * p.inverse_modulus[i];
      for (std::size_t k = 0; k < 3; ++k)
        extension.set(4 * (p.first + i) + k, p.displacement[i][static_cast<int>(k)]);
      extension.set(4 * (p.first + i) + 3, factor * sum, std::abs(factor) * size_sum);
    }
    wanted = {{"extension", extension}};
  }
};

TEST_P(OrdinaryState, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::ordinary_state::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                 limit);
  }
}

TEST_P(OrdinaryState, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::ordinary_state::Args>(GetParam(), Problem(129), {"displacement", 4, 1},
                                                      {"extension", 4});
}

TEST_P(OrdinaryState, NothingOnceTheSolverHasStopped) {
  expect_nothing_when_stopped<kernels::ordinary_state::Args>(GetParam(), Problem(17), "extension");
}

} // namespace
} // namespace pliant::test
