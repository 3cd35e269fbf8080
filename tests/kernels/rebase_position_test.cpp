// rebase_position: positions lose what their body's origin gained; the mass stays.
#include "kernels/rebase_position.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(RebasePosition);

TEST_P(RebasePosition, Formula) {
  for (const std::size_t size : awkward_sizes) {
    Random random(kernel_seed + 26);
    Values in;
    in["origin_shift"] = random_groups(random, 4, 8);
    in["position"] = guarded(random_groups(random, size, 8), 4);
    if (size > 20) in["position"][4 * 11] = not_a_number;
    Expected position(in["position"]);
    for (std::size_t i = 0; i < size; ++i) {
      in["owner"].push_back(double((3 * i) % 4));
      for (std::size_t k = 0; k < 3; ++k) // one difference, rounded once
        position.set(4 * i + k, in["position"][4 * i + k] - in["origin_shift"][4 * ((3 * i) % 4) + k], 16);
    }
    expect_kernel<kernels::rebase_position::Args>(GetParam(), static_cast<std::uint32_t>(size), in,
                                                  {{"position", position}}, 0.5);
  }
}

} // namespace
} // namespace pliant::test
