// inversion_force: adds sum (c_ij B_i + c_ji B_j) xi to the force, and sum c_ij b_i + c_ji b_j to the
// diagonal.
#include "kernels/inversion_force.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(InversionForce);

// As corotated_force: a few roundings a term, of both signs; 0.5 seen. The diagonal's up to 26 terms are of
// one sign, so that the running sum is rounded at its full size: half a rounding each.
constexpr double limit = 2;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size, bool product = false) : p("ordinary", size, kernel_seed + 33) {
    Random random(kernel_seed + 34);
    in = p.bond_values;
    in["product"] = {double(product)};
    in["solver"] = solver_running;
    in["solver"][13] = product; // SOLVER_LINEAR
    std::vector<Matrix3> b;
    std::vector<double> share;
    std::vector<double> record = p.buffer(12, not_a_number), force = p.buffer(4, sentinel);
    for (std::size_t i = 0; i < p.count; ++i) {
      b.push_back((Matrix3() << random.vector(), random.vector(), random.vector()).finished());
      share.push_back(i % 2 ? rounded(1 + random()) : 0);
      for (std::size_t k = 0; k < 12; ++k)
        record[12 * (p.first + i) + k] = k % 4 < 3 ? b[i](static_cast<int>(k / 4), static_cast<int>(k % 4))
                                         : k == 3  ? share[i]
                                                   : 0;
      for (std::size_t k = 0; k < 4; ++k) force[4 * (p.first + i) + k] = random(10);
    }
    in["inversion"] = record;
    in["force"] = force;
    Expected out(force);
    for (std::size_t i = 0; i < p.count; ++i) {
      const double* before = force.data() + 4 * (p.first + i);
      Vector3 sum(before[0], before[1], before[2]);
      double size_sum = sum.norm(), stiffness = before[3];
      for (const auto& bond : p.bonds[i]) {
        sum += (bond.out * b[i] + bond.in * b[bond.to]) * bond.reference;
        size_sum += (bond.out * b[i].norm() + bond.in * b[bond.to].norm()) * bond.reference.norm();
        stiffness += product ? 0 : bond.out * share[i] + bond.in * share[bond.to];
      }
      for (int k = 0; k < 3; ++k) out.set(4 * (p.first + i) + static_cast<std::size_t>(k), sum[k], size_sum);
      out.set(4 * (p.first + i) + 3, stiffness, product ? 0 : 5 * std::abs(stiffness));
    }
    wanted = {{"force", out}};
  }
};

TEST_P(InversionForce, Formula) {
  for (const std::size_t size : awkward_sizes)
    for (const bool product : {false, true}) {
      const Problem problem(size, product);
      expect_kernel<kernels::inversion_force::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                    limit);
    }
}

TEST_P(InversionForce, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::inversion_force::Args>(GetParam(), Problem(129), {"inversion", 12, 5},
                                                       {"force", 4});
}

TEST_P(InversionForce, NothingOnceTheSolverHasStopped) {
  Problem problem(17);
  problem.in["solver"][0] = 1;
  const Values out =
      run_kernel<kernels::inversion_force::Args>(OpenDevices::of(GetParam()), problem.p.count, problem.in);
  EXPECT_EQ(out.at("force"), problem.in.at("force"));
}

} // namespace
} // namespace pliant::test
