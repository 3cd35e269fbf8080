// plastic_sum: particles that flow, work, the largest plastic strain and the volume gained, in one row.
#include "kernels/plastic_sum.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(PlasticSum);

TEST_P(PlasticSum, Formula) {
  for (const std::size_t size : awkward_sizes) {
    Random random(kernel_seed + 105);
    Values in;
    in["particle_count"] = {double(size)};
    in["row"] = {1};
    double flowing = 0, work = 0, largest = 0, volume = 0, volumes = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double row[] = {std::abs(random(2)), std::abs(random(3)), random(1e-3), i % 3 == 0 ? 1.0 : 0.0};
      in["flow"].insert(in["flow"].end(), row, row + 4);
      in["flow"].insert(in["flow"].end(), 4, not_a_number);
      flowing += row[3], work += row[1], largest = std::max(largest, row[0]), volume += row[2];
      volumes += std::abs(row[2]);
    }
    in["plastic_row"] = std::vector<double>(12, sentinel);
    Expected row(in["plastic_row"]);
    row.set(4, flowing);
    row.set(5, work, work);
    row.set(6, largest);
    row.set(7, volume, volumes);
    // A chain of 8 sums and a tree of 7 on a GPU.
    expect_kernel<kernels::plastic_sum::Args>(GetParam(), kernels::plastic_sum::group_size, in,
                                              {{"plastic_row", row}}, 16);
  }
}

} // namespace
} // namespace pliant::test
