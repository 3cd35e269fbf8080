// inversion_energy: its formula is held to in inversion_state_test.cpp, beside the force of which it is the
// potential; here what it leaves alone.
#include "kernels/inversion_energy.h"
#include "tests/support/kernel_tensors.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(InversionEnergy);

// A body stretched and sheared, but nowhere inverted, keeps its energy bit for bit; so does every one behind
// the gate.
TEST_P(InversionEnergy, NothingWhereNothingIsInverted) {
  BondProblem p("ordinary", 127, kernel_seed + 35);
  Values in = p.bond_values;
  in["stride"] = {double(p.total)};
  in["position"] = p.vectors(p.position);
  in["displacement"] = p.vectors(p.displacement);
  in["inversion_shape"] = p.buffer(9, not_a_number);
  in["energy"] = p.buffer(1, 7.0);
  std::size_t healthy = 0;
  for (std::size_t i = 0; i < p.count; ++i) {
    Matrix3 yx = Matrix3::Zero(), xx = Matrix3::Zero();
    for (const auto& bond : p.bonds[i]) {
      yx += p.inverse_modulus[i] * bond.out * p.current(i, bond) * bond.reference.transpose();
      xx += p.inverse_modulus[i] * bond.out * bond.reference * bond.reference.transpose();
    }
    const bool full = Polar(xx).value[2] > 0.05 && Polar(yx * xx.inverse()).value[2] > 0.15;
    healthy += full;
    const Matrix3 inverse = full ? Matrix3(xx.inverse()) : Matrix3::Identity();
    const double row[] = {p.inverse_modulus[i], full ? 1.5 : 0, 4,
                          inverse(0, 0),        inverse(0, 1),  inverse(0, 2),
                          inverse(1, 1),        inverse(1, 2),  inverse(2, 2)};
    for (std::size_t k = 0; k < 9; ++k) in["inversion_shape"][k * p.total + p.first + i] = rounded(row[k]);
  }
  EXPECT_GT(healthy, 60u);
  Device& device = OpenDevices::of(GetParam());
  EXPECT_EQ(run_kernel<kernels::inversion_energy::Args>(device, p.count, in).at("energy"), in.at("energy"));
  for (std::size_t k = p.total; k < 2 * p.total; ++k) in["inversion_shape"][k] = 1.5;
  for (std::size_t i = 0; i < p.count; ++i) in["displacement"][4 * (p.first + i)] += 0.125 * double(i % 7);
  EXPECT_NE(run_kernel<kernels::inversion_energy::Args>(device, p.count, in).at("energy"), in.at("energy"));
  in["gated"] = {1};
  in["gate"] = {1, 0, 0, 0};
  EXPECT_EQ(run_kernel<kernels::inversion_energy::Args>(device, p.count, in).at("energy"), in.at("energy"));
}

} // namespace
} // namespace pliant::test
