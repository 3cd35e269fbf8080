// ordinary_force: f_i = sum (c_ij (y - x (1 - phi_i)) + c_ji (y - x (1 - phi_j))) n; n that of the reference
// where two particles coincide, as two of these do.
#include "kernels/ordinary_force.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(OrdinaryForce);

// A length takes three roundings (a driver's sqrt may be wrong by two epsilon) and is a third of the scale
// where it is x: one; its term and the sum add as much. 0.2 seen.
constexpr double limit = 2;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size) : p("ordinary", size, kernel_seed + 8, true) {
    Random random(kernel_seed + 9);
    in = p.bond_values;
    in["position"] = p.vectors(p.position);
    in["solver"] = solver_running;
    std::vector<double> phi(p.count);
    for (double& value : phi) value = random(0.3);
    in["extension"] = p.rows(not_a_number, 4, [&](std::size_t i, std::size_t k) {
      return k < 3 ? p.displacement[i][static_cast<int>(k)] : phi[i];
    });
    in["linear_start"] = p.rows(
        not_a_number, 4, [](std::size_t i, std::size_t k) { return k < 3 ? sentinel : 7 + double(i); });
    in["force"] = p.buffer(4, sentinel);
    Expected force(in["force"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      Vector3 sum = Vector3::Zero();
      double size_sum = 0;
      for (const auto& bond : p.bonds[i]) {
        const Vector3 y = p.current(i, bond);
        const double x = bond.reference.norm(), length = y.norm();
        const Vector3 n = length > 0 ? Vector3(y / length) : Vector3(bond.reference / x);
        sum += (bond.out * (length - x * (1 - phi[i])) + bond.in * (length - x * (1 - phi[bond.to]))) * n;
        size_sum += (bond.out + bond.in) * (length + 2 * x);
      }
      for (int k = 0; k < 3; ++k)
        force.set(4 * (p.first + i) + static_cast<std::size_t>(k), sum[k], size_sum);
      force.set(4 * (p.first + i) + 3, 7 + double(i));
    }
    wanted = {{"force", force}};
  }
};

TEST_P(OrdinaryForce, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::ordinary_force::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                 limit);
  }
}

TEST_P(OrdinaryForce, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::ordinary_force::Args>(GetParam(), Problem(129), {"extension", 4, 3},
                                                      {"force", 4});
}

TEST_P(OrdinaryForce, NothingOnceTheSolverHasStopped) {
  expect_nothing_when_stopped<kernels::ordinary_force::Args>(GetParam(), Problem(17), "force");
}

} // namespace
} // namespace pliant::test
