// prescribe: held particles go to M x0 + m, relative to their body's origin and their position; the rest are
// let be.
#include "kernels/prescribe.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(Prescribe);

constexpr double limit = 6; // three products, two differences; 1 seen

struct Problem {
  Values in;
  std::map<std::string, Expected> wanted;
  std::vector<std::size_t> held;
  explicit Problem(std::size_t count) {
    Random random(kernel_seed + 24);
    in["motion"] = random_groups(random, 192, 1);
    in["origin"] = random_groups(random, 3, 10);
    in["position"] = random_groups(random, count, 1);
    for (const char* name : {"inertia_target", "displacement"}) {
      in[name] = guarded(random_groups(random, count, 1), 4);
      wanted[name] = Expected(in[name]);
    }
    for (std::size_t i = 0; i < count; ++i) in["owner"].push_back(double(i % 3));
    for (std::size_t i = 0; i < count; i += 2) held.push_back(i);
    std::shuffle(held.begin(), held.end(), random.engine());
    in["held_start"] = guarded(random_groups(random, held.size(), 10), 4);
    for (std::size_t entry = 0; entry < held.size(); ++entry) {
      const std::size_t i = held[entry], motion = (7 * entry) % 64;
      in["held"].insert(in["held"].end(), {double(i), double(motion)});
      const Vector3 start = vector_at(in["held_start"], entry), o = vector_at(in["origin"], i % 3),
                    y = vector_at(in["position"], i);
      Vector3 u, size;
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t row = 3 * motion + static_cast<std::size_t>(axis);
        const Vector3 m = vector_at(in["motion"], row);
        u[axis] = m.dot(start) + in["motion"][4 * row + 3] - o[axis] - y[axis];
        size[axis] = m.cwiseAbs().dot(start.cwiseAbs()) + 1 + std::abs(o[axis]) + std::abs(y[axis]);
      }
      for (const char* name : {"inertia_target", "displacement"}) {
        set_vector(wanted[name], i, u, size);
        wanted[name].set(4 * i + 3, name == std::string("inertia_target") ? -1 : 0);
      }
    }
  }
  std::uint32_t threads() const { return static_cast<std::uint32_t>(held.size()); }
};

TEST_P(Prescribe, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    expect_kernel<kernels::prescribe::Args>(GetParam(), problem.threads(), problem.in, problem.wanted, limit);
  }
}

TEST_P(Prescribe, NotANumberStaysWhereItIs) {
  Problem problem(129);
  Device& device = OpenDevices::of(GetParam());
  const Values clean = run_kernel<kernels::prescribe::Args>(device, problem.threads(), problem.in);
  problem.in["position"][4 * problem.held[9]] = not_a_number;
  const Values spoiled = run_kernel<kernels::prescribe::Args>(device, problem.threads(), problem.in);
  expect_contained("displacement", clean.at("displacement"), spoiled.at("displacement"), 4, {problem.held[9]},
                   problem.held[9]);
}

} // namespace
} // namespace pliant::test
