// bond_release: what was in a bond before it broke, less what is left.
#include "kernels/bond_release.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(BondRelease);

TEST_P(BondRelease, Formula) {
  for (const std::size_t size : awkward_sizes) {
    Random random(kernel_seed + 93);
    Values in;
    for (const char* name : {"before", "energy", "released"})
      for (std::size_t i = 0; i < size + 3; ++i) in[name].push_back(random(5));
    Expected released(in["released"]);
    for (std::size_t i = 0; i < size; ++i) {
      const double b = in["before"][i], e = in["energy"][i], r = in["released"][i];
      released.set(i, r + (b - e), std::abs(r) + std::abs(b) + std::abs(e));
    }
    expect_kernel<kernels::bond_release::Args>(GetParam(), static_cast<std::uint32_t>(size), in,
                                               {{"released", released}}, 2);
  }
}

} // namespace
} // namespace pliant::test
