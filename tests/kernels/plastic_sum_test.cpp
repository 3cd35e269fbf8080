// plastic_sum: particles that flow, work, the largest plastic strain, the volume gained and the largest share
// of a strain that was lost, in one row.
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
    double flowing = 0, work = 0, largest = 0, volume = 0, volumes = 0, lost = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double row[] = {std::abs(random(2)), std::abs(random(3)), random(1e-3), i % 3 == 0 ? 1.0 : 0.0};
      in["flow"].insert(in["flow"].end(), row, row + 4);
      const double stays[] = {not_a_number, rounded(0.7 + random(0.3)), rounded(0.8 + random(0.2)),
                              not_a_number};
      in["flow"].insert(in["flow"].end(), stays, stays + 4);
      lost = std::max(lost, 1 - std::min(stays[1], stays[2]));
      flowing += row[3], work += row[1], largest = std::max(largest, row[0]), volume += row[2];
      volumes += std::abs(row[2]);
    }
    in["plastic_row"] = std::vector<double>(15, sentinel);
    Expected row(in["plastic_row"]);
    row.set(5, flowing);
    row.set(6, work, work);
    row.set(7, largest);
    row.set(8, volume, volumes);
    row.set(9, lost, 1);
    // A chain of 8 sums and a tree of 7 on a GPU.
    expect_kernel<kernels::plastic_sum::Args>(GetParam(), kernels::plastic_sum::group_size, in,
                                              {{"plastic_row", row}}, 16);
  }
}

} // namespace
} // namespace pliant::test
