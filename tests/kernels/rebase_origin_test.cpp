// rebase_origin: origins move by whole quanta, exactly, and stay where a particle has gone astray.
#include "kernels/rebase_origin.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(RebaseOrigin);

TEST_P(RebaseOrigin, WholeQuanta) {
  for (const std::size_t bodies : {1, 15, 129}) {
    Random random(kernel_seed + 25);
    Values in;
    in["position"] = random_groups(random, 2 * bodies, 20);
    in["origin"] = guarded(random_groups(random, bodies, 1), 4);
    in["origin_shift"] = guarded(std::vector<double>(4 * bodies, 1.0), 4);
    Expected origin(in["origin"]), shift(in["origin_shift"]);
    for (std::size_t b = 0; b < bodies; ++b) {
      const std::size_t anchor = 2 * b + 1;
      const double quantum = std::exp2(double(b % 5) - 3);
      in["anchor"].push_back(double(anchor));
      in["origin"][4 * b + 3] = quantum;
      for (std::size_t k = 0; k < 3; ++k) {
        double& o = in["origin"][4 * b + k];
        o = 64 * quantum * std::round(o * 8); // as the engine keeps them: whole quanta
        if (b == 7 && k == 1) in["position"][4 * anchor + k] = anything;
        if (b == 9 && k == 2) in["position"][4 * anchor + k] = not_a_number;
        const double y = in["position"][4 * anchor + k];
        const double wanted = std::isfinite(y) ? quantum * std::nearbyint(y / quantum) : 0;
        origin.set(4 * b + k, o + wanted);
        shift.set(4 * b + k, wanted);
      }
      origin.set(4 * b + 3, quantum);
      shift.set(4 * b + 3, 0);
    }
    expect_kernel<kernels::rebase_origin::Args>(GetParam(), static_cast<std::uint32_t>(bodies), in,
                                                {{"origin", origin}, {"origin_shift", shift}}, 0);
  }
}

} // namespace
} // namespace pliant::test
