// projective_force: sum c_ij (Y - x (d dir(F_i xi) + (1 - d) dir Y)) + c_ji (Y - x (d dir(F_j xi) + (1 - d)
// dir Y)).
#include "kernels/projective_force.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(ProjectiveForce);

// A direction takes three roundings (a driver's sqrt may be wrong by two epsilon) of x, a share of at most a
// half of the scale: 1.5; the products and the sum add one. F xi cancels where F is nearly singular, so its
// own terms are in the scale. 0.5 seen.
constexpr double limit = 2.5;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size, double deviatoric = 0.5) : p("projective", size, kernel_seed + 12) {
    Random random(kernel_seed + 13);
    in = p.bond_values;
    in["deviatoric"] = {deviatoric};
    in["position"] = p.vectors(p.position);
    in["solver"] = solver_running;
    std::vector<Matrix3> f;
    in["record"] = p.buffer(12, not_a_number);
    for (std::size_t i = 0; i < p.count; ++i) {
      f.push_back(Matrix3::Identity() +
                  0.5 * (Matrix3() << random.vector(), random.vector(), random.vector()).finished());
      for (double& value : f[i].reshaped()) value = rounded(value);
      for (std::size_t k = 0; k < 12; ++k)
        in["record"][12 * (p.first + i) + k] = k % 4 < 3
                                                   ? f[i](static_cast<int>(k / 4), static_cast<int>(k % 4))
                                                   : p.displacement[i][static_cast<int>(k / 4)];
    }
    in["linear_start"] = p.rows(
        not_a_number, 4, [](std::size_t i, std::size_t k) { return k < 3 ? sentinel : 3 + double(i); });
    in["force"] = p.buffer(4, sentinel);
    Expected force(in["force"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      Vector3 sum = Vector3::Zero();
      double size_sum = 0;
      for (const auto& bond : p.bonds[i]) {
        const Vector3 y = p.current(i, bond), from_i = f[i] * bond.reference,
                      from_j = f[bond.to] * bond.reference;
        const double x = bond.reference.norm();
        const Vector3 direct = (1 - deviatoric) * y.normalized();
        sum += bond.out * (y - x * (deviatoric * from_i.normalized() + direct)) +
               bond.in * (y - x * (deviatoric * from_j.normalized() + direct));
        size_sum += bond.out * (y.norm() + x * (1 + f[i].norm() * x / from_i.norm())) +
                    bond.in * (y.norm() + x * (1 + f[bond.to].norm() * x / from_j.norm()));
      }
      for (int k = 0; k < 3; ++k)
        force.set(4 * (p.first + i) + static_cast<std::size_t>(k), sum[k], size_sum);
      force.set(4 * (p.first + i) + 3, 3 + double(i));
    }
    wanted = {{"force", force}};
  }
};

TEST_P(ProjectiveForce, Formula) {
  for (const double deviatoric : {0.0, 0.375, 1.0})
    for (const std::size_t size : awkward_sizes) {
      const Problem problem(size, deviatoric);
      expect_kernel<kernels::projective_force::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                     limit);
    }
}

TEST_P(ProjectiveForce, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::projective_force::Args>(GetParam(), Problem(129), {"record", 12, 3},
                                                        {"force", 4});
}

TEST_P(ProjectiveForce, NothingOnceTheSolverHasStopped) {
  expect_nothing_when_stopped<kernels::projective_force::Args>(GetParam(), Problem(17), "force");
}

} // namespace
} // namespace pliant::test
