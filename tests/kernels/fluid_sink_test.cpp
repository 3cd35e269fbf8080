// fluid_sink: who is in a region loses its mass and is counted, once, by the first that holds it.
#include "kernels/fluid_sink.h"
#include "shaders/common/contact.glsl"
#include "shaders/common/fluid.glsl"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FluidSink);

TEST_P(FluidSink, RegionsTakeWhatIsInThem) {
  std::vector<double> table(4 * OBSTACLES * OBSTACLE_ROWS, 0.0);
  const auto row = [&](int sink, int at, std::array<double, 4> values) {
    std::copy(values.begin(), values.end(), table.begin() + 4 * (OBSTACLE_ROWS * sink + at));
  };
  const auto region = [&](int sink, int kind, const Vector3& centre, const Vector3& size) {
    row(sink, OBSTACLE_KIND, {double(kind), 0, 0, 0});
    row(sink, OBSTACLE_CENTRE, {centre.x(), centre.y(), centre.z(), rounded(1e18)});
    row(sink, OBSTACLE_SIZE, {size.x(), size.y(), size.z(), 1});
    for (int a = 0; a < 3; ++a)
      row(sink, OBSTACLE_AXES + a, {a == 0 ? 1.0 : 0, a == 1 ? 1.0 : 0, a == 2 ? 1.0 : 0, 0});
  };
  region(0, OBSTACLE_PLANE, {0, -0.5, 0}, {0, 0, 0}); // below y = -0.5
  region(1, OBSTACLE_SPHERE, {0.5, 0.5, 0}, {0.25, 0, 0});
  region(2, OBSTACLE_BOX, {-0.5, 0.25, 0}, {0.25, 0.125, 0.5});
  region(3, OBSTACLE_CYLINDER, {0, 0.75, 0.5}, {0.25, 0.125, 0});
  region(4, OBSTACLE_TORUS, {0, 0, -0.5}, {0.25, 0.125, 0});
  // The second is turned by a quarter about z, so that its long edge lies along y.
  row(2, OBSTACLE_AXES, {0, -1, 0, 0});
  row(2, OBSTACLE_AXES + 1, {1, 0, 0, 0});
  Random random(kernel_seed + 62);
  const std::size_t count = 3000;
  const Vector3 base(0.25, -0.125, 0.0625);
  Values in{{"sinks", {5}},
            {"base_x", {base.x()}},
            {"base_y", {base.y()}},
            {"base_z", {base.z()}},
            {"sink", table},
            {"origin", random_groups(random, 3, 1)},
            {"velocity", random_groups(random, count, 1)},
            {"sunk", {10, 0, 0, 0, 1, 77}}};
  Expected velocity(in["velocity"]);
  std::vector<double> sunk = in["sunk"], position;
  std::vector<bool> taken(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 place = random.vector();
    in["fluid_kind"].push_back(double(i % 3 | (i % 2) << FLUID_KIND_SHIFT));
    const Vector3 y = rounded(Vector3(place + base - vector_at(in["origin"], i % 3)));
    const double mass = i % 5 == 2 ? 0 : 1;
    for (const double value : {y.x(), y.y(), y.z(), mass}) position.push_back(value);
    const Vector3 p = y + vector_at(in["origin"], i % 3) - base;
    const auto box = [](double at, double half) { return std::abs(at) - half; };
    const double distances[] = {p.y() + 0.5, (p - Vector3(0.5, 0.5, 0)).norm() - 0.25,
                                std::max({box(p.x() + 0.5, 0.125), box(p.y() - 0.25, 0.25), box(p.z(), 0.5)}),
                                std::max(std::hypot(p.x(), p.z() - 0.5) - 0.25, box(p.y() - 0.75, 0.125)),
                                std::hypot(std::hypot(p.x(), p.z() + 0.5) - 0.25, p.y()) - 0.125};
    for (int s = 0; s < 5; ++s) {
      ASSERT_GT(std::abs(distances[s]), 1e-6) << "too near a face to tell";
      if (mass == 0 || distances[s] >= 0) continue;
      position.back() = 0, sunk[std::size_t(s)] += 1, taken[i] = true;
      for (std::size_t c = 0; c < 4; ++c) velocity.set(4 * i + c, 0, 0);
      break;
    }
  }
  for (int s = 0; s < 5; ++s) EXPECT_GT(sunk[std::size_t(s)], 10) << "nothing is in region " << s;
  const std::vector<double> after = position;
  for (std::size_t i = 0; i < count; ++i)
    if (taken[i]) position[4 * i + 3] = 1;
  in["position"] = position;
  Expected place(position), counts(in["sunk"]);
  for (std::size_t i = 0; i < count; ++i) place.set(4 * i + 3, after[4 * i + 3], 0);
  for (std::size_t s = 0; s < 5; ++s) counts.set(s, sunk[s], 0);
  expect_kernel<kernels::fluid_sink::Args>(GetParam(), static_cast<std::uint32_t>(count), in,
                                           {{"position", place}, {"velocity", velocity}, {"sunk", counts}},
                                           0);
}

} // namespace
} // namespace pliant::test
