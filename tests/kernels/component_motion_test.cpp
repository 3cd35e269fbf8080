// component_motion: shift -sum m d / M, rotation -I^-1 L about the centre of mass; nothing for what is held.
#include "kernels/component_motion.h"
#include "tests/support/kernel_components.h"

#include <Eigen/LU>

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(ComponentMotion);

// L and I about the centre are differences of sums about the origin, and a 3 x 3 matrix is inverted: the
// scale has their magnitudes, and the regularisation of I too (1e-5 of its trace in float, 1e-14 in double).
// 13 seen.
constexpr double limit = 60;

struct Problem {
  ComponentProblem p;
  Values in;
  explicit Problem(const std::vector<std::size_t>& sizes) : p(sizes, kernel_seed + 32, 0.01, 0.02) {
    in["component"] = p.component;
    for (std::size_t g = 0; g < p.chunks; ++g) {
      const auto s =
          p.moments(static_cast<std::size_t>(p.chunk[4 * g]), static_cast<std::size_t>(p.chunk[4 * g + 1]));
      const double w[] = {s.mass, 0, 0, 0, 0};
      const Vector3* rows[] = {&s.drift, &s.centre, &s.spin, &s.square, &s.mixed};
      for (std::size_t r = 0; r < 5; ++r)
        in["moment"].insert(in["moment"].end(), {rounded(rows[r]->x()), rounded(rows[r]->y()),
                                                 rounded(rows[r]->z()), rounded(w[r])});
    }
    in["rigid"] = guarded(std::vector<double>(12 * sizes.size(), 1.0), 4);
  }
  // The wanted rows, from the moments as the device gets them.
  std::map<std::string, Expected> wanted() const {
    Expected rigid(in.at("rigid"));
    const std::vector<double>& moment = in.at("moment");
    for (std::size_t c = 0; c < p.ranges.size(); ++c) {
      Vector3 sum[5];
      for (Vector3& s : sum) s.setZero();
      double mass = 0, held = 0;
      for (auto g = static_cast<std::size_t>(p.component[4 * c]);
           g < static_cast<std::size_t>(p.component[4 * c + 1]); ++g) {
        for (std::size_t r = 0; r < 5; ++r) sum[r] += vector_at(moment, 5 * g + r);
        mass += moment[20 * g + 3];
        held += moment[20 * g + 7];
      }
      for (std::size_t r = 0; r < 12; ++r) rigid.set(12 * c + r, 0);
      if (held > 0) continue;
      const Vector3 mean = sum[0] / mass, centre = sum[1] / mass;
      set_vector(rigid, 3 * c, -mean, mean.cwiseAbs());
      set_vector(rigid, 3 * c + 2, centre, centre.cwiseAbs());
      if (in.at("component")[4 * c + 2] == 0) continue;
      const Vector3 l = sum[2] - mass * centre.cross(mean);
      Matrix3 about_origin;
      about_origin << sum[3][0], sum[4][0], sum[4][1], sum[4][0], sum[3][1], sum[4][2], sum[4][1], sum[4][2],
          sum[3][2];
      const Matrix3 about = about_origin - mass * centre * centre.transpose();
      const Matrix3 inertia = about.trace() * Matrix3::Identity() - about, inverse = inertia.inverse();
      const Vector3 turn = -inverse * l;
      const double amplified = inverse.norm() * (sum[2].norm() + mass * centre.norm() * mean.norm()) +
                               inverse.norm() * turn.norm() * about_origin.trace();
      const bool single = about.trace() < 1e-5 * about_origin.trace(); // one particle has nothing to turn
      set_vector(rigid, 3 * c + 1, turn, Vector3::Constant(single ? anything : amplified));
    }
    return {{"rigid", rigid}};
  }
};

TEST_P(ComponentMotion, Formula) {
  for (const std::vector<std::size_t>& sizes :
       {std::vector<std::size_t>{17}, {15, 17, 127, 129, 1000}, std::vector<std::size_t>(130, 9)}) {
    const Problem problem(sizes);
    expect_kernel<kernels::component_motion::Args>(GetParam(), static_cast<std::uint32_t>(sizes.size()),
                                                   problem.in, problem.wanted(), limit);
  }
}

TEST_P(ComponentMotion, HeldOnesAndThoseWithoutSpin) {
  Problem problem({17, 40, 50, 1});
  problem.in["moment"][7] = 1;            // one particle of the first component is held or touched
  problem.in["component"][4 * 2 + 2] = 0; // the third one's law does not conserve angular momentum
  const Values out =
      expect_kernel<kernels::component_motion::Args>(GetParam(), 4, problem.in, problem.wanted(), limit);
  for (std::size_t k = 0; k < 12; ++k) EXPECT_EQ(out.at("rigid")[k], 0) << k;
  EXPECT_GT(vector_at(out.at("rigid"), 3 + 1).norm(), 0.001);
  EXPECT_EQ(vector_at(out.at("rigid"), 6 + 1).norm(), 0);
  EXPECT_LT(vector_at(out.at("rigid"), 9 + 1).norm(), 1) << "one particle must not be spun";
}

} // namespace
} // namespace pliant::test
