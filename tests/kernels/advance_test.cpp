// advance: positions and velocities at the end of a step of implicit Euler or BDF2, and the share of gravity
// felt.
#include "kernels/advance.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(Advance);

constexpr double limit = 6; // a difference, a division by the step; 1 seen

struct Problem {
  Values in;
  std::map<std::string, Expected> wanted;
  Problem(std::size_t count, bool bdf2, bool history, const Vector3& gravity = {0.5, -9.8125, 0.25}) {
    Random random(kernel_seed + 23);
    constexpr double h = 1.0 / 64;
    in = {{"bdf2", {double(bdf2)}},
          {"history", {double(history)}},
          {"time_step", {h}},
          {"gravity_x", {gravity[0]}},
          {"gravity_y", {gravity[1]}},
          {"gravity_z", {gravity[2]}},
          {"displacement", random_groups(random, count, 0.05)},
          {"position", guarded(random_groups(random, count, 3), 4)},
          {"velocity", guarded(random_groups(random, count, 3), 4)}};
    const std::vector<double> earlier = random_groups(random, count, 0.05);
    if (history)
      in.insert({{"earlier_velocity", guarded(std::vector<double>(4 * count, 1.0), 4)},
                 {"earlier_shift", guarded(earlier, 4)}});
    for (const char* name : {"position", "velocity", "earlier_velocity", "earlier_shift"})
      if (in.count(name)) wanted[name] = Expected(in[name]);
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 u = vector_at(in["displacement"], i), y = vector_at(in["position"], i),
                    v = vector_at(in["velocity"], i);
      const Vector3 past = bdf2 ? Vector3(vector_at(earlier, i) / 3) : Vector3(Vector3::Zero());
      const Vector3 after = (u - past) / h, size = (u.cwiseAbs() + past.cwiseAbs()) / h;
      set_vector(wanted["position"], i, y + u, y.cwiseAbs() + u.cwiseAbs());
      set_vector(wanted["velocity"], i, after, size);
      const double g2 = gravity.squaredNorm();
      const double felt = g2 > 0 ? std::clamp((after - v).dot(gravity) / (h * g2), 0.0, 1.0) : 0.0;
      wanted["velocity"].set(4 * i + 3, felt,
                             g2 > 0 ? (size + v.cwiseAbs()).dot(gravity.cwiseAbs()) / (h * g2) : 0);
      if (!history) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        wanted["earlier_velocity"].set(4 * i + k, in["velocity"][4 * i + k]);
        wanted["earlier_shift"].set(4 * i + k, k < 3 ? in["displacement"][4 * i + k] : 0);
      }
    }
  }
};

TEST_P(Advance, Euler) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size, false, false);
    expect_kernel<kernels::advance::Args>(GetParam(), static_cast<std::uint32_t>(size), problem.in,
                                          problem.wanted, limit);
  }
}

TEST_P(Advance, Bdf2AndItsFirstStep) {
  for (const bool bdf2 : {false, true})
    for (const std::size_t size : awkward_sizes) {
      const Problem problem(size, bdf2, true);
      expect_kernel<kernels::advance::Args>(GetParam(), static_cast<std::uint32_t>(size), problem.in,
                                            problem.wanted, limit);
    }
}

TEST_P(Advance, WithoutGravityNoneIsFelt) {
  const Problem problem(17, false, false, Vector3::Zero());
  expect_kernel<kernels::advance::Args>(GetParam(), 17, problem.in, problem.wanted, limit);
}

TEST_P(Advance, NotANumberStaysWhereItIs) {
  Problem problem(129, true, true);
  Device& device = OpenDevices::of(GetParam());
  const Values clean = run_kernel<kernels::advance::Args>(device, 129, problem.in);
  problem.in["displacement"][4 * 77 + 1] = not_a_number;
  const Values spoiled = run_kernel<kernels::advance::Args>(device, 129, problem.in);
  for (const char* name : {"position", "velocity", "earlier_shift"})
    expect_contained(name, clean.at(name), spoiled.at(name), 4, {77}, 77);
}

} // namespace
} // namespace pliant::test
