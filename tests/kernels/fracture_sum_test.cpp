// fracture_sum: bonds broken and energy released of all particles, in one row.
#include "kernels/fracture_sum.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FractureSum);

TEST_P(FractureSum, Formula) {
  for (const std::size_t size : awkward_sizes) {
    Random random(kernel_seed + 94);
    Values in;
    in["particle_count"] = {double(size)};
    in["broken_at"] = {7};
    in["row"] = {1};
    in["shape"] = std::vector<double>(7 + size + 2, not_a_number);
    double broken = 0, energy = 0;
    for (std::size_t i = 0; i < size; ++i) {
      in["shape"][7 + i] = double(2 * (i % 4));
      in["released"].push_back(std::abs(random(3)));
      broken += in["shape"][7 + i] / 2;
      energy += in["released"][i];
    }
    in["fracture"] = std::vector<double>(6, sentinel);
    Expected row(in["fracture"]);
    row.set(2, broken);
    row.set(3, energy, energy);
    // A chain of 8 sums and a tree of 7 on a GPU.
    expect_kernel<kernels::fracture_sum::Args>(GetParam(), kernels::fracture_sum::group_size, in,
                                               {{"fracture", row}}, 16);
  }
}

} // namespace
} // namespace pliant::test
