// fluid_emit: point + flown, the layer's velocity, and nothing else is touched.
#include "kernels/fluid_emit.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FluidEmit);

TEST_P(FluidEmit, LayersAreBornInTheirSlots) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{37}, std::size_t{200}}) {
    Random random(kernel_seed + 61);
    const std::size_t all = 3 * count + 5;
    const Vector3 flown = rounded(random.vector()), speed = rounded(random.vector(3));
    Values in{{"emitter", {1}},
              {"emitter_count", {3, 0, 5, 0, 9, 1}},
              {"first", {7}},
              {"flown_x", {flown.x()}},
              {"flown_y", {flown.y()}},
              {"flown_z", {flown.z()}},
              {"held", {0.375}},
              {"speed_x", {speed.x()}},
              {"speed_y", {speed.y()}},
              {"speed_z", {speed.z()}},
              {"emitter_point", random_groups(random, count + 7, 1)},
              {"position", random_groups(random, all, 1)},
              {"velocity", random_groups(random, all, 1)}};
    for (std::size_t k = 0; k < count; ++k) in["emitter_slot"].push_back(double((all - 1) - 3 * k));
    Expected position(in["position"]), velocity(in["velocity"]), born(in["emitter_count"]);
    born.set(2, 5 + double(count), 0);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = (all - 1) - 3 * k;
      const Vector3 point = vector_at(in["emitter_point"], 7 + k);
      set_vector(position, i, point + flown, point.cwiseAbs() + flown.cwiseAbs());
      position.set(4 * i + 3, in["emitter_point"][4 * (7 + k) + 3], 0);
      set_vector(velocity, i, speed, Vector3::Zero());
      velocity.set(4 * i + 3, 0.375, 0);
    }
    // One sum, rounded once.
    expect_kernel<kernels::fluid_emit::Args>(
        GetParam(), static_cast<std::uint32_t>(count), in,
        {{"position", position}, {"velocity", velocity}, {"emitter_count", born}}, 1);
  }
}

} // namespace
} // namespace pliant::test
