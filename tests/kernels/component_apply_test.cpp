// component_apply: u + shift + (Q - 1)(y + u - centre), Q the rotation whose tangent of half the angle is
// half |w|; and with component_moments and component_motion before it, a rigid error is taken out.
#include "kernels/component_apply.h"
#include "kernels/component_moments.h"
#include "kernels/component_motion.h"
#include "tests/support/kernel_components.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(ComponentApply);

constexpr double limit = 3; // two cross products and three sums: five roundings of half an epsilon; 0.6 seen

TEST_P(ComponentApply, Formula) {
  const ComponentProblem p({1, 15, 17, 127, 129, 1000}, kernel_seed + 33, 0.01, 0.02);
  Random random(kernel_seed + 34);
  std::vector<double> rigid = random_groups(random, 3 * p.ranges.size(), 0.5);
  for (std::size_t k = 4; k < 8; ++k) rigid[k] = 0; // the first only shifts
  Values in{{"chunk", p.chunk},
            {"rigid", rigid},
            {"position", p.position},
            {"displacement", guarded(p.displacement, 4)}};
  Expected displacement(in["displacement"]);
  for (std::size_t c = 0; c < p.ranges.size(); ++c) {
    const Vector3 shift = vector_at(rigid, 3 * c), w = vector_at(rigid, 3 * c + 1),
                  centre = vector_at(rigid, 3 * c + 2);
    Matrix3 q = Matrix3::Identity();
    if (w.norm() > 0) q = Eigen::AngleAxisd(2 * std::atan(w.norm() / 2), w.normalized()).toRotationMatrix();
    for (std::size_t i = p.ranges[c].first; i < p.ranges[c].second; ++i) {
      const Vector3 u = vector_at(p.displacement, i), x = p.y(i) - centre;
      const double size =
          u.norm() + shift.norm() + (q - Matrix3::Identity()).norm() * (p.y(i).norm() + centre.norm());
      set_vector(displacement, i, u + shift + (q - Matrix3::Identity()) * x, Vector3::Constant(size));
      displacement.set(4 * i + 3, 0);
    }
  }
  expect_kernel<kernels::component_apply::Args>(
      GetParam(), static_cast<std::uint32_t>(p.chunks) * kernels::component_apply::group_size, in,
      {{"displacement", displacement}}, limit);
}

// Two passes, as a step does them.
Values restore(Device& device, const ComponentProblem& p, const std::vector<double>& touched) {
  Values state{{"displacement", p.displacement}};
  const auto threads = static_cast<std::uint32_t>(p.chunks) * kernels::component_moments::group_size;
  for (int pass = 0; pass < 2; ++pass) {
    const Values moments =
        run_kernel<kernels::component_moments::Args>(device, threads,
                                                     {{"contacts", {1}},
                                                      {"chunk", p.chunk},
                                                      {"position", p.position},
                                                      {"displacement", state.at("displacement")},
                                                      {"inertia_target", p.target},
                                                      {"touched", touched},
                                                      {"moment", std::vector<double>(20 * p.chunks, 0.0)}});
    const Values motion = run_kernel<kernels::component_motion::Args>(
        device, static_cast<std::uint32_t>(p.ranges.size()),
        {{"component", p.component},
         {"moment", moments.at("moment")},
         {"rigid", std::vector<double>(12 * p.ranges.size(), 0.0)}});
    state = run_kernel<kernels::component_apply::Args>(device, threads,
                                                       {{"chunk", p.chunk},
                                                        {"rigid", motion.at("rigid")},
                                                        {"position", p.position},
                                                        {"displacement", state.at("displacement")}});
  }
  return state;
}

TEST_P(ComponentApply, TakesTheRestOfMomentumOut) {
  ComponentProblem p({129, 300, 40, 60}, kernel_seed + 35, 0.01, 0.02);
  std::vector<double> touched(p.count, 0.0);
  touched[p.ranges[2].first + 7] = 1;
  p.target[4 * (p.ranges[3].first + 9) + 3] = -1;
  ComponentProblem after = p;
  after.displacement = restore(OpenDevices::of(GetParam()), p, touched).at("displacement");
  for (std::size_t c = 0; c < p.ranges.size(); ++c) {
    const auto [begin, end] = p.ranges[c];
    if (c >= 2) { // touched, held: not a bit of it moves
      for (std::size_t k = 4 * begin; k < 4 * end; ++k)
        EXPECT_EQ(after.displacement[k], p.displacement[k]) << "component " << c;
      continue;
    }
    const auto old_rest = p.moments(begin, end), rest = after.moments(begin, end);
    const Vector3 centre = rest.centre / rest.mass, spin = rest.spin - centre.cross(rest.drift);
    const Vector3 old_centre = old_rest.centre / old_rest.mass,
                  old_spin = old_rest.spin - old_centre.cross(old_rest.drift);
    // One pass leaves the square of the angle and the regularisation, two their product; then rounding is
    // all.
    const double floor = 60 * GetParam().epsilon();
    const double linear = rest.drift.norm() / old_rest.drift.norm(), angular = spin.norm() / old_spin.norm();
    std::printf("%s, component %zu: momentum left %.1e, angular %.1e of the first\n", GetParam().name.c_str(),
                c, linear, angular);
    EXPECT_LT(linear, floor);
    EXPECT_LT(angular, floor + 4e-4 * 4e-4 + 0.05 * std::pow(0.02, 3));
  }
}

} // namespace
} // namespace pliant::test
