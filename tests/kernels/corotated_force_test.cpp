// corotated_force: f_i = sum (c_ij + c_ji) Y - (c_ij A_i + c_ji A_j) xi.
#include "kernels/corotated_force.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(CorotatedForce);

// A term takes four roundings of half an epsilon of itself, so two; terms of both signs keep the running sum,
// and its roundings, well below the sum of magnitudes that is the scale. 0.4 seen.
constexpr double limit = 2;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size) : p("corotated", size, kernel_seed + 3) {
    Random random(kernel_seed + 4);
    in = p.bond_values;
    in["solver"] = solver_running;
    std::vector<Matrix3> a;
    std::vector<Vector3> start;
    std::vector<double> record = p.buffer(12, not_a_number), linear = p.buffer(4, not_a_number);
    for (std::size_t i = 0; i < p.count; ++i) {
      a.push_back((Matrix3() << random.vector(), random.vector(), random.vector()).finished());
      start.push_back(random.vector());
      for (std::size_t k = 0; k < 12; ++k)
        record[12 * (p.first + i) + k] = k % 4 < 3 ? a[i](static_cast<int>(k / 4), static_cast<int>(k % 4))
                                                   : p.displacement[i][static_cast<int>(k / 4)];
      for (std::size_t k = 0; k < 4; ++k)
        linear[4 * (p.first + i) + k] = k < 3 ? start[i][static_cast<int>(k)] : 100 + double(i);
    }
    in["record"] = record;
    in["linear_start"] = linear;
    in["force"] = p.buffer(4, sentinel);
    Expected force(in["force"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      Vector3 sum = start[i];
      double size_sum = start[i].norm();
      for (const auto& bond : p.bonds[i]) {
        const Vector3 u = p.displacement[bond.to] - p.displacement[i];
        sum += (bond.out + bond.in) * u - (bond.out * a[i] + bond.in * a[bond.to]) * bond.reference;
        size_sum += (bond.out + bond.in) * u.norm() +
                    (bond.out * a[i].norm() + bond.in * a[bond.to].norm()) * bond.reference.norm();
      }
      for (int k = 0; k < 3; ++k)
        force.set(4 * (p.first + i) + static_cast<std::size_t>(k), sum[k], size_sum);
      force.set(4 * (p.first + i) + 3, 100 + double(i));
    }
    wanted = {{"force", force}};
  }
};

TEST_P(CorotatedForce, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::corotated_force::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                  limit);
  }
}

TEST_P(CorotatedForce, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::corotated_force::Args>(GetParam(), Problem(129), {"record", 12, 5},
                                                       {"force", 4});
}

TEST_P(CorotatedForce, NothingOnceTheSolverHasStopped) {
  expect_nothing_when_stopped<kernels::corotated_force::Args>(GetParam(), Problem(17), "force");
}

} // namespace
} // namespace pliant::test
