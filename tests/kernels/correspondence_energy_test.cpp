// correspondence_energy: with D = sum c (Y - R xi) (x) xi, F - R = D K^-1 / (3 mu V) and H = R^T F - 1,
// mu V (|H|^2 / 2 - I2(H) - det H) + lambda V / 2 (J - 1)^2 + (sum c |Y - R xi|^2 - (F - R) : D) / 2. That
// this is the energy of the law is tests/physics/tension.cpp's to show.
#include "kernels/correspondence_energy.h"
#include "tests/support/kernel_tensors.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(CorrespondenceEnergy);

// Y - R xi is wrong by two roundings of its terms, twice in a square, and again through F; 2 seen.
constexpr double limit = 10;

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
    const Matrix3 inverse = symmetric_rows(in["shape"], random, p, i, 11);
    Eigen::Quaterniond q = random.rotation();
    for (double& value : q.coeffs()) value = rounded(value);
    for (std::size_t c = 0; c < 4; ++c)
      in["rotation"][4 * (p.first + i) + c] = q.coeffs()[static_cast<int>(c)];
    const Matrix3 r = q.toRotationMatrix();
    Matrix3 d = Matrix3::Zero();
    double deviation = 0, size = 0, size_d = 0;
    for (const auto& bond : p.bonds[i]) {
      const Vector3 y = p.current(i, bond), off = y - r * bond.reference;
      const double size_off = y.norm() + bond.reference.norm();
      deviation += bond.out * off.squaredNorm();
      d += bond.out * off * bond.reference.transpose();
      size += bond.out * off.norm() * size_off;
      size_d += bond.out * size_off * bond.reference.norm();
    }
    const double inverse_modulus = p.inverse_modulus[i];
    const Matrix3 excess = inverse_modulus * d * inverse, h = r.transpose() * excess;
    const double trace = h.trace(), pairs = (trace * trace - (h * h).trace()) / 2,
                 growth = trace + pairs + h.determinant();
    const double stiffness = 1 + p.coupling[i] / 1.5;
    double affine = 0;
    if (inverse_modulus > 0)
      affine = (h.squaredNorm() / 2 - pairs - h.determinant() + stiffness / 2 * growth * growth) /
               (3 * inverse_modulus);
    const double n = inverse_modulus * size_d * inverse.norm(); // size of the terms of H
    const double size_growth = n + n * n + n * n * n;
    if (inverse_modulus > 0)
      size += (n * n + n * n * n + stiffness * std::abs(growth) * size_growth) / (3 * inverse_modulus);
    energy.set(p.first + i, affine + (deviation - excess.cwiseProduct(d).sum()) / 2, size + n * size_d);
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
  const Values out = run_kernel<kernels::correspondence_energy::Args>(OpenDevices::of(GetParam()),
                                                                      problem.p.count, problem.in);
  EXPECT_EQ(out.at("energy"), problem.in.at("energy"));
}

} // namespace
} // namespace pliant::test
