// guard_apply: copies alone, so every bit must agree.
#include "kernels/guard_apply.h"
#include "shaders/common/solver.glsl"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(GuardApply);

TEST_P(GuardApply, KeepsOrRestores) {
  for (const std::size_t size : awkward_sizes)
    for (const double action : {0.0, 1.0, 2.0, 3.0}) {
      Random random(kernel_seed + 22);
      Values in;
      for (const char* name : {"displacement", "earlier_iterate", "best_iterate"})
        in[name] = guarded(random_groups(random, size, 1), 4);
      in["displacement"][1] = not_a_number;
      in["solver"] =
          std::vector<double>(SOLVER_ENTRIES, 1.0); // also stopped: the last decision is still carried out
      in["solver"][SOLVER_ACTION] = action;
      std::map<std::string, Expected> wanted;
      for (const char* name : {"displacement", "earlier_iterate", "best_iterate"})
        wanted[name] = Expected(in[name]);
      in["inertia_target"] = random_groups(random, size, 1);
      for (std::size_t i = 0; i < size; ++i) in["inertia_target"][4 * i + 3] = i % 5 == 3 ? -1 : 2;
      const auto& source = action != 2 ? in["earlier_iterate"] : in["best_iterate"];
      for (std::size_t k = 0; k < 4 * size && action > 0; ++k) {
        wanted["best_iterate"].set(k, source[k]);
        if (action == 1 || (action == 3 && k / 4 % 5 == 3)) continue;
        wanted["displacement"].set(k, action == 3 ? 0 : source[k]);
        wanted["earlier_iterate"].set(k, action == 3 ? 0 : source[k]);
      }
      expect_kernel<kernels::guard_apply::Args>(GetParam(), static_cast<std::uint32_t>(size), in, wanted, 0);
    }
}

} // namespace
} // namespace pliant::test
