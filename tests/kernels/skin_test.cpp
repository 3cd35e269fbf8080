// skin: x = sum w_k (y_k + F_k (X - X_k)); a linear field carries vertices along exactly.
#include "kernels/skin.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(Skin);

// A difference, three products and their sums, a weight, and the sum of four: six roundings of half an
// epsilon of what they act on. 0.7 seen.
constexpr double limit = 3;

struct Problem {
  Values in;
  Problem(std::size_t vertices, std::size_t particles, const Matrix3* linear) {
    Random random(kernel_seed + 44);
    in["reference"] = random_groups(random, particles, 1);
    in["gradient"] = random_groups(random, 3 * particles, 1);
    in["particle"] = random_groups(random, particles, 1);
    in["skin_reference"] = random_groups(random, vertices, 1);
    in["vertex"] = guarded(std::vector<double>(4 * vertices, 0.0), 4);
    for (std::size_t v = 0; v < vertices; ++v) {
      double weight[4], sum = 0;
      for (double& w : weight) sum += w = std::abs(random()) + 0.1;
      double left = 1; // exact in float, and their sum exactly one
      for (std::size_t k = 0; k < 4; ++k) {
        const double w = k < 3 ? std::round(weight[k] / sum * 1024) / 1024 : left;
        left -= w;
        in["skin_weight"].push_back(w);
        in["skin_particle"].push_back(double((v * 7 + k * 11) % particles));
      }
    }
    if (!linear) return;
    for (std::size_t i = 0; i < particles; ++i) {
      const Vector3 y = rounded(Vector3(*linear * vector_at(in["reference"], i)));
      for (std::size_t k = 0; k < 3; ++k) in["particle"][4 * i + k] = y[static_cast<int>(k)];
      for (std::size_t k = 0; k < 9; ++k)
        in["gradient"][12 * i + 4 * (k / 3) + k % 3] =
            (*linear)(static_cast<int>(k / 3), static_cast<int>(k % 3));
    }
  }
  std::map<std::string, Expected> wanted() const {
    Expected vertex(in.at("vertex"));
    for (std::size_t v = 0; v < in.at("skin_reference").size() / 4; ++v) {
      Vector3 x = Vector3::Zero();
      double size = 0, field = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto j = static_cast<std::size_t>(in.at("skin_particle")[4 * v + k]);
        const double w = in.at("skin_weight")[4 * v + k];
        Matrix3 f;
        for (int r = 0; r < 3; ++r)
          f.row(r) = vector_at(in.at("gradient"), 3 * j + static_cast<std::size_t>(r));
        const Vector3 rest = vector_at(in.at("skin_reference"), v), own = vector_at(in.at("reference"), j),
                      y = vector_at(in.at("particle"), j);
        x += w * (y + f * (rest - own));
        size += std::abs(w) * (y.norm() + f.norm() * (rest.norm() + own.norm()));
        field += w * in.at("particle")[4 * j + 3];
      }
      set_vector(vertex, v, x, Vector3::Constant(size));
      vertex.set(4 * v + 3, field, 2);
    }
    return {{"vertex", vertex}};
  }
};

TEST_P(Skin, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size, 50, nullptr);
    expect_kernel<kernels::skin::Args>(GetParam(), static_cast<std::uint32_t>(size), problem.in,
                                       problem.wanted(), limit);
  }
}

TEST_P(Skin, LinearFieldsAreExact) {
  Matrix3 linear;
  linear << 1.25, 0.5, 0, -0.25, 0.75, 0.125, 0.5, 0, 1; // exact in float
  const Problem problem(200, 50, &linear);
  const Values out = run_kernel<kernels::skin::Args>(OpenDevices::of(GetParam()), 200, problem.in);
  double worst = 0;
  for (std::size_t v = 0; v < 200; ++v)
    worst = std::max(
        worst,
        (vector_at(out.at("vertex"), v) - linear * vector_at(problem.in.at("skin_reference"), v)).norm());
  std::printf("%s: vertices off by %.1e\n", GetParam().name.c_str(), worst);
  EXPECT_LT(worst, 1e-6); // the particles' own places are rounded to float
}

TEST_P(Skin, NotANumberReachesItsVerticesOnly) {
  Problem problem(129, 50, nullptr);
  Device& device = OpenDevices::of(GetParam());
  const Values clean = run_kernel<kernels::skin::Args>(device, 129, problem.in);
  problem.in["particle"][4 * 7] = not_a_number;
  const Values spoiled = run_kernel<kernels::skin::Args>(device, 129, problem.in);
  std::vector<std::size_t> reached;
  for (std::size_t k = 0; k < 4 * 129; ++k)
    if (problem.in["skin_particle"][k] == 7) reached.push_back(k / 4);
  ASSERT_FALSE(reached.empty());
  expect_contained("vertex", clean.at("vertex"), spoiled.at("vertex"), 4, reached, reached[0]);
}

} // namespace
} // namespace pliant::test
