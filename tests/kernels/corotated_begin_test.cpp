// corotated_begin: sum c Yn (x) xi and sum (c_ij + c_ji) Yn.
#include "kernels/corotated_begin.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(CorotatedBegin);

// Sums of up to 26 products: one rounding each at most, 3 seen.
constexpr double limit = 15;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size) : p("corotated", size, kernel_seed) {
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["shape"] = p.shape(11);
    in["linear_start"] = p.rows(sentinel, 4, [](std::size_t i, std::size_t k) { return double(10 * i + k); });
    Expected shape(in["shape"]), linear(in["linear_start"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      Matrix3 s = Matrix3::Zero(), size_s = Matrix3::Zero();
      Vector3 sum = Vector3::Zero(), size_sum = Vector3::Zero();
      for (const auto& bond : p.bonds[i]) {
        const Vector3 y = p.position[bond.to] - p.position[i];
        s += bond.out * y * bond.reference.transpose();
        size_s += bond.out * (y * bond.reference.transpose()).cwiseAbs();
        sum += (bond.out + bond.in) * y;
        size_sum += (bond.out + bond.in) * y.cwiseAbs();
      }
      for (int k = 0; k < 9; ++k)
        shape.set(static_cast<std::size_t>(k + 2) * p.total + p.first + i, s(k / 3, k % 3),
                  size_s(k / 3, k % 3));
      for (int k = 0; k < 3; ++k)
        linear.set(4 * (p.first + i) + static_cast<std::size_t>(k), sum[k], size_sum[k]);
    }
    wanted = {{"shape", shape}, {"linear_start", linear}};
  }
};

TEST_P(CorotatedBegin, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::corotated_begin::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                  limit);
  }
}

TEST_P(CorotatedBegin, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::corotated_begin::Args>(GetParam(), Problem(129), {"position", 4, 0},
                                                       {"linear_start", 4});
}

} // namespace
} // namespace pliant::test
