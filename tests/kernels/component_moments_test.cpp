// component_moments: sums of m d, m, m y, m y x d and m y y over each chunk, and how many particles are held
// or touched.
#include "kernels/component_moments.h"
#include "tests/support/kernel_components.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(ComponentMoments);

// A chain of up to 340 sums one after the other on the CPU, whose roundings partly cancel; 4 seen in float.
constexpr double limit = 20;

TEST_P(ComponentMoments, Formula) {
  for (const bool contacts : {false, true}) {
    ComponentProblem p({1, 15, 17, 127, 129, 1000}, kernel_seed + 30, 0.01, 0.02);
    std::vector<double> touched(p.count, 0.0);
    p.target[4 * 20 + 3] = -1;
    for (const std::size_t i : {3, 20, 200, 201}) touched[i] = 1; // 20: both held and touched, counted once
    Values in{
        {"contacts", {double(contacts)}}, {"chunk", p.chunk},
        {"position", p.position},         {"displacement", p.displacement},
        {"inertia_target", p.target},     {"moment", guarded(std::vector<double>(20 * p.chunks, 1.0), 4)}};
    if (contacts) in["touched"] = touched;
    Expected moment(in["moment"]);
    for (std::size_t g = 0; g < p.chunks; ++g) {
      const auto begin = static_cast<std::size_t>(p.chunk[4 * g]),
                 end = static_cast<std::size_t>(p.chunk[4 * g + 1]);
      const ComponentProblem::Moments s = p.moments(begin, end);
      double held = 0;
      for (std::size_t i = begin; i < end; ++i)
        held += p.target[4 * i + 3] < 0 || (contacts && touched[i] > 0);
      set_vector(moment, 5 * g, s.drift, Vector3::Constant(s.size_drift));
      set_vector(moment, 5 * g + 1, s.centre, Vector3::Constant(s.size_centre));
      set_vector(moment, 5 * g + 2, s.spin, Vector3::Constant(s.size_spin));
      set_vector(moment, 5 * g + 3, s.square, Vector3::Constant(s.size_square));
      set_vector(moment, 5 * g + 4, s.mixed, Vector3::Constant(s.size_square));
      moment.set(20 * g + 3, s.mass, s.mass);
      moment.set(20 * g + 7, held);
      for (const std::size_t w : {11, 15, 19}) moment.set(20 * g + w, 0);
    }
    expect_kernel<kernels::component_moments::Args>(
        GetParam(), static_cast<std::uint32_t>(p.chunks) * kernels::component_moments::group_size, in,
        {{"moment", moment}}, limit);
  }
}

TEST_P(ComponentMoments, NotANumberStaysInItsChunk) {
  const ComponentProblem p({17, 300}, kernel_seed + 31, 0.01, 0.02);
  Values in{{"contacts", {0}},
            {"chunk", p.chunk},
            {"position", p.position},
            {"displacement", p.displacement},
            {"inertia_target", p.target},
            {"moment", std::vector<double>(20 * p.chunks, 1.0)}};
  const auto threads = static_cast<std::uint32_t>(p.chunks) * kernels::component_moments::group_size;
  Device& device = OpenDevices::of(GetParam());
  const Values clean = run_kernel<kernels::component_moments::Args>(device, threads, in);
  in["displacement"][4 * 16] = not_a_number;
  const Values spoiled = run_kernel<kernels::component_moments::Args>(device, threads, in);
  std::size_t chunk = 0;
  while (p.chunk[4 * chunk + 1] <= 16) ++chunk;
  expect_contained("moment", clean.at("moment"), spoiled.at("moment"), 20, {chunk}, chunk);
}

} // namespace
} // namespace pliant::test
