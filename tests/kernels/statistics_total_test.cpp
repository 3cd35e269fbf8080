// statistics_total: one row of sixteen, where it is told to, and no other.
#include "kernels/statistics_total.h"
#include "shaders/common/solver.glsl"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(StatisticsTotal);

constexpr double limit = 20; // a chain of up to 1000 sums on the CPU; 5 seen in float

TEST_P(StatisticsTotal, Formula) {
  for (const std::size_t chunks : awkward_sizes) {
    Random random(kernel_seed + 38);
    Values in;
    in["chunk_count"] = {double(chunks)};
    in["row"] = {2};
    in["chunk_sum"] = random_groups(random, 2 * chunks, 5);
    for (std::size_t c = 0; c < chunks; ++c) {
      for (const std::size_t k : {0, 1, 2, 7})
        in["chunk_sum"][8 * c + k] = std::abs(in["chunk_sum"][8 * c + k]);
      in["chunk_sum"][8 * c + 3] = double(c % 3);
    }
    in["solver"] = random_groups(random, SOLVER_ENTRIES / 4, 100);
    in["statistics"] = std::vector<double>(64, sentinel);
    double total[8] = {}, scale[8] = {};
    for (std::size_t c = 0; c < chunks; ++c) {
      const double* s = &in["chunk_sum"][8 * c];
      const double added[] = {s[0], s[1], 0, s[3], s[4], s[5], s[6], 0};
      for (std::size_t k = 0; k < 8; ++k) total[k] += added[k], scale[k] += std::abs(added[k]);
      total[2] = std::max(total[2], std::sqrt(s[2]));
      total[7] = std::max(total[7], std::sqrt(s[7]));
    }
    scale[2] = total[2];
    scale[3] = 0; // a count is exact
    scale[7] = total[7];
    Expected row(in["statistics"]);
    for (std::size_t k = 0; k < 8; ++k) row.set(32 + k, total[k], scale[k]);
    constexpr std::size_t entries[] = {SOLVER_FIRST,         SOLVER_BEST,     SOLVER_FLOOR,
                                       SOLVER_ITERATIONS,    SOLVER_RESTARTS, SOLVER_REASON,
                                       SOLVER_ONE_MINUS_RHO, SOLVER_GAMMA};
    for (std::size_t k = 0; k < 8; ++k) row.set(40 + k, in["solver"][entries[k]]);
    expect_kernel<kernels::statistics_total::Args>(GetParam(), kernels::statistics_total::group_size, in,
                                                   {{"statistics", row}}, limit);
  }
}

} // namespace
} // namespace pliant::test
