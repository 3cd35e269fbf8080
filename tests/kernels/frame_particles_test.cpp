// frame_particles: scene + origin + position, and the field of each colour.
#include "kernels/frame_particles.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FrameParticles);

constexpr double limit = 6; // three sums and a root; 1 seen

TEST_P(FrameParticles, Formula) {
  for (const std::size_t count : awkward_sizes)
    for (int field : {0, 1, 2, 3, 4, 6}) {
      Random random(kernel_seed + 43);
      const Vector3 scene(64, -32, 16);
      Values in{{"field", {double(field)}},
                {"scene_x", {64}},
                {"scene_y", {-32}},
                {"scene_z", {16}},
                {"origin", random_groups(random, 3, 4)},
                {"position", random_groups(random, count, 1)},
                {"particle", guarded(std::vector<double>(4 * count, 0.0), 4)}};
      // Only what this field needs is there.
      const std::vector<double> velocity = random_groups(random, count, 2),
                                gradient = random_groups(random, 3 * count, 1);
      std::vector<double> start = random_groups(random, count, 40), energy(count);
      for (double& value : energy) value = std::abs(random(5));
      for (std::size_t i = 0; i < count; ++i) start[4 * i + 3] = rounded(1 + std::abs(start[4 * i + 3]));
      if (field == 1) in["velocity"] = velocity;
      if (field == 2) in["gradient"] = gradient;
      if (field == 3) in["energy"] = energy;
      if (field == 3 || field == 4) in["start"] = start;
      const std::vector<double> flow = random_groups(random, 2 * count, 1);
      if (field == 6) in["flow"] = flow;
      Expected particle(in["particle"]);
      for (std::size_t i = 0; i < count; ++i) {
        in["owner"].push_back(double(i % 3));
        const Vector3 o = vector_at(in["origin"], i % 3), y = vector_at(in["position"], i), x = scene + o + y;
        const Vector3 size = scene.cwiseAbs() + o.cwiseAbs() + y.cwiseAbs();
        set_vector(particle, i, x, size);
        const double wanted[] = {0,
                                 vector_at(velocity, i).norm(),
                                 gradient[12 * i + 3],
                                 energy[i] / start[4 * i + 3],
                                 (x - vector_at(start, i)).norm(),
                                 0,
                                 flow[8 * i]};
        const double scale[] = {0, wanted[1], 0, wanted[3], size.norm() + 1, 0, 0};
        particle.set(4 * i + 3, wanted[field], scale[field]);
      }
      expect_kernel<kernels::frame_particles::Args>(GetParam(), static_cast<std::uint32_t>(count), in,
                                                    {{"particle", particle}}, limit);
    }
}

// What has no mass is not there.
TEST_P(FrameParticles, GoneIsNowhere) {
  Random random(kernel_seed + 44);
  Values in{{"gone", {1}},
            {"origin", random_groups(random, 1, 4)},
            {"owner", std::vector<double>(33, 0.0)},
            {"position", random_groups(random, 33, 1)},
            {"particle", std::vector<double>(4 * 33, 0.0)}};
  for (std::size_t i = 0; i < 33; ++i) in["position"][4 * i + 3] = i % 3 == 1 ? 0 : 1;
  const Values out = run_kernel<kernels::frame_particles::Args>(OpenDevices::of(GetParam()), 33, in);
  for (std::size_t i = 0; i < 33; ++i)
    for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(std::isinf(out.at("particle")[4 * i + c]), i % 3 == 1) << i;
}

} // namespace
} // namespace pliant::test
