// inversion_state: B = rho (F - F^) K^-1, F^ being F with its signed singular values raised to 0.1; and
// inversion_energy, which adds rho / 2 V modulus |F - F^|^2.
#include "kernels/inversion_energy.h"
#include "kernels/inversion_state.h"
#include "tests/support/kernel_tensors.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(InversionState);

// Sums of up to 26 products, a singular value decomposition whose condition is in the scale, two products; 3
// seen.
constexpr double limit = 40;
constexpr double least = 0.1;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> record, energy;
  std::size_t inverted = 0;
  explicit Problem(std::size_t particles) : p("ordinary", particles, kernel_seed + 31) {
    Random random(kernel_seed + 32);
    for (std::size_t i = 0; i < p.count; i += 3) // every third particle sees a mirror image
      p.displacement[i].y() = rounded(p.displacement[i].y() + 1.5 * p.spacing);
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["inversion_shape"] = p.buffer(9, not_a_number);
    Expected rows(p.buffer(12, sentinel)), stored(p.buffer(1, 7.0));
    for (std::size_t i = 0; i < p.count; ++i) expect(random, rows, stored, i);
    record = {{"inversion", rows}};
    energy = {{"energy", stored}};
  }
  Values state_values() const {
    Values values = in;
    values["solver"] = solver_running;
    values["inversion"] = p.buffer(12, sentinel);
    return values;
  }
  Values energy_values() const {
    Values values = in;
    values["energy"] = p.buffer(1, 7.0);
    return values;
  }

  void expect(Random& random, Expected& rows, Expected& stored, std::size_t i) {
    const std::size_t at = p.first + i;
    const bool asked = i % 5 != 0 || i == p.busiest(); // the others are of a material that is not pushed back
    const double push = asked ? 1.25 : 0, share = rounded(2 + 0.5 * random());
    in["inversion_shape"][at] = p.inverse_modulus[i];
    in["inversion_shape"][p.total + at] = push;
    in["inversion_shape"][2 * p.total + at] = share;
    const Matrix3 inverse = symmetric_rows(in["inversion_shape"], random, p, i, 3);
    Matrix3 sum = Matrix3::Zero();
    double terms = 0;
    for (const auto& bond : p.bonds[i]) {
      sum += bond.out * p.current(i, bond) * bond.reference.transpose();
      terms += bond.out * p.current(i, bond).norm() * bond.reference.norm();
    }
    const Matrix3 f = p.inverse_modulus[i] * sum * inverse;
    const double error = p.inverse_modulus[i] * terms * inverse.norm();
    Matrix3 off = Matrix3::Zero();
    double size = 0;
    const Polar polar(f);
    bool active = false, sure = true;
    if (asked) {
      if (polar.value[2] < least) {
        active = true;
        off = f - polar.u * polar.value.cwiseMax(least).asDiagonal() * polar.v.transpose();
        size = polar.condition == anything ? anything : polar.condition * (error + 0.1);
      }
      sure = std::abs(polar.value[2] - least) > 1e-3 * (error + 0.1);
      if (!sure) size = anything;
    }
    inverted += active;
    const Matrix3 b = push * off * inverse;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t c = 0; c < 3; ++c)
        rows.set(12 * at + 4 * row + c, b(static_cast<int>(row), static_cast<int>(c)),
                 push * size * inverse.norm());
      rows.set(12 * at + 4 * row + 3, row == 0 && active ? share : 0, row == 0 && !sure ? anything : 0);
    }
    if (!asked) return;
    if (p.bonds[i].empty()) { // no volume, no energy: what a model never asks for
      stored.set(at, 0, anything);
      in["inversion_shape"][p.total + at] = 0;
      for (std::size_t k = 0; k < 12; ++k) rows.set(12 * at + k, 0);
      stored.set(at, 7.0);
      return;
    }
    const double per_square = push / p.inverse_modulus[i] / 2;
    stored.set(at, 7 + per_square * off.squaredNorm(),
               7 + per_square * (off.norm() * size + off.squaredNorm()));
    if (size == anything) stored.set(at, 0, anything);
  }
};

TEST_P(InversionState, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::inversion_state::Args>(GetParam(), problem.p.count, problem.state_values(),
                                                  problem.record, limit);
    expect_kernel<kernels::inversion_energy::Args>(GetParam(), problem.p.count, problem.energy_values(),
                                                   problem.energy, limit);
    if (size >= 127) {
      EXPECT_GT(problem.inverted, size / 40);
    }
  }
}

TEST_P(InversionState, NotANumberReachesNeighboursOnly) {
  const Problem problem(129);
  const BondProblem& p = problem.p;
  Values spoiled = problem.state_values();
  const std::size_t at = p.busiest();
  const Values clean =
      run_kernel<kernels::inversion_state::Args>(OpenDevices::of(GetParam()), p.count, spoiled);
  spoiled["displacement"][4 * (p.first + at) + 1] = not_a_number;
  const Values out =
      run_kernel<kernels::inversion_state::Args>(OpenDevices::of(GetParam()), p.count, spoiled);
  expect_contained("inversion", clean.at("inversion"), out.at("inversion"), 12, p.reach(at), p.first + at);
}

TEST_P(InversionState, NothingOnceTheSolverHasStopped) {
  const Problem problem(17);
  Values in = problem.state_values();
  in["solver"][0] = 1;
  const Values out =
      run_kernel<kernels::inversion_state::Args>(OpenDevices::of(GetParam()), problem.p.count, in);
  EXPECT_EQ(out.at("inversion"), in.at("inversion"));
}

} // namespace
} // namespace pliant::test
