// deformation: the gradient of an affine field is found whatever the neighbourhood; directions that the
// neighbours do not span take the rotation; the equivalent strain.
#include "kernels/deformation.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(Deformation);

// The scale multiplies the norms of a sum, of an inverse and of its condition, whose worst cases never meet:
// what is left of their roundings is below one. 0.13 seen.
constexpr double limit = 1;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  std::vector<int> rank; ///< directions that a particle's bonds span
  Problem(std::size_t size, const Matrix3* affine) : p("corotated", size, kernel_seed + 40) {
    if (affine)
      for (std::size_t i = 0; i < p.count; ++i) p.position[i] = rounded(Vector3(*affine * p.reference[i]));
    in = p.bond_values;
    in["position"] = p.vectors(p.position);
    in["gradient"] = p.buffer(12, sentinel);
    Expected gradient(in["gradient"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      Matrix3 yx = Matrix3::Zero(), xx = Matrix3::Zero();
      double terms = 0;
      for (const auto& bond : p.bonds[i]) {
        const Vector3 y = p.position[bond.to] - p.position[i];
        yx += bond.out * y * bond.reference.transpose();
        xx += bond.out * bond.reference * bond.reference.transpose();
        terms += bond.out * y.norm() * bond.reference.norm();
      }
      Matrix3 f = Matrix3::Identity();
      double error = 0;
      int spanned = 0;
      if (xx.trace() > 0) {
        const Eigen::JacobiSVD<Matrix3> svd(xx);
        for (int k = 0; k < 3; ++k) spanned += svd.singularValues()[k] > 1e-6 * xx.trace();
        const double e = 1e-3 * xx.trace();
        const Polar polar(yx);
        const Matrix3 inverse = (xx + e * Matrix3::Identity()).inverse();
        f = (yx + e * polar.rotation) * inverse;
        // A sum and a rotation that are wrong, and a matrix with the condition 1 / smallest to be inverted.
        error = (terms + e * (polar.condition == anything ? 0 : polar.condition)) * inverse.norm() *
                xx.trace() * inverse.norm();
        if (polar.condition == anything) error = anything;
      }
      rank.push_back(spanned);
      const Matrix3 green = (f.transpose() * f - Matrix3::Identity()) / 2;
      const Matrix3 deviator = green - green.trace() / 3 * Matrix3::Identity();
      for (std::size_t k = 0; k < 12; ++k)
        gradient.set(12 * (p.first + i) + k,
                     k % 4 < 3 ? f(static_cast<int>(k / 4), static_cast<int>(k % 4)) : 0,
                     k % 4 < 3 ? error : 0);
      gradient.set(12 * (p.first + i) + 3, std::sqrt(2.0 / 3) * deviator.norm(), 2 * f.norm() * (error + 1));
    }
    wanted = {{"gradient", gradient}};
  }
};

Matrix3 gradient_of(const Values& out, std::size_t i) {
  Matrix3 f;
  for (std::size_t k = 0; k < 9; ++k)
    f(static_cast<int>(k / 3), static_cast<int>(k % 3)) = out.at("gradient")[12 * i + 4 * (k / 3) + k % 3];
  return f;
}

TEST_P(Deformation, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size, nullptr);
    expect_kernel<kernels::deformation::Args>(GetParam(), problem.p.count, problem.in, problem.wanted, limit);
  }
}

TEST_P(Deformation, AffineFieldIsRecovered) {
  Random random(kernel_seed + 41);
  const Matrix3 turn = random.rotation().toRotationMatrix();
  const Matrix3 stretched = turn * Vector3(1.3, 0.9, 1.1).asDiagonal();
  double worst = 0;
  for (const Matrix3& affine : {turn, stretched}) {
    const Problem problem(1000, &affine);
    const Values out =
        run_kernel<kernels::deformation::Args>(OpenDevices::of(GetParam()), problem.p.count, problem.in);
    std::size_t flat = 0;
    for (std::size_t i = 0; i < problem.p.count; ++i) {
      const Matrix3 f = gradient_of(out, problem.p.first + i);
      ASSERT_TRUE(f.allFinite()) << "particle " << i << " whose bonds span " << problem.rank[i]
                                 << " directions";
      flat += problem.rank[i] < 3;
      if (problem.rank[i] < 3) {
        EXPECT_LT(f.norm(), 4) << "particle " << i;
        continue;
      }
      // Positions come as floats, so bonds are wrong by 1e-7 of the body's size over the spacing: 2e-6 seen
      // of a rotation. A stretch is pulled towards the rotation by e / (smallest moment + e), which is
      // largest for the least spanned direction.
      const double pulled = &affine == &turn || affine == turn ? 0 : 0.35;
      const double error = (f - affine).norm();
      EXPECT_LT(error, 1e-5 + pulled * 0.3) << "particle " << i;
      if (affine == turn) {
        worst = std::max(worst, error);
        EXPECT_LT(out.at("gradient")[12 * (problem.p.first + i) + 3], 1e-5) << "a rotation is no strain";
      }
    }
    EXPECT_LT(flat, problem.p.count / 3);
  }
  std::printf("%s: rotation recovered to %.1e\n", GetParam().name.c_str(), worst);
}

// A sheet and a rod, turned and stretched: their own directions follow, the missing ones keep the rotation.
TEST_P(Deformation, MissingDirectionsTakeTheRotation) {
  for (const bool rod : {false, true}) {
    Problem problem(127, nullptr);
    BondProblem& p = problem.p;
    Random random(kernel_seed + 42);
    const Matrix3 turn = Eigen::AngleAxisd(0.4, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    // Bonds out of the sheet (or off the rod) lose their weight.
    std::vector<double> weight = problem.in["weight"];
    const std::vector<double>& packed = problem.in["bond"];
    for (std::size_t k = 64; k < packed.size(); k += 32)
      for (std::size_t lane = 0; lane < 16; ++lane) {
        const auto word = static_cast<std::uint32_t>(packed[k + 16 + lane]);
        const bool off_sheet = (word >> 20) & 1023u, off_rod = (word >> 10) & 1023u;
        if (off_sheet || (rod && off_rod)) weight[k + lane] = 0;
      }
    problem.in["weight"] = weight;
    for (std::size_t i = 0; i < p.count; ++i) {
      Vector3 x = p.reference[i];
      x.x() *= 1.2;
      p.position[i] = rounded(Vector3(turn * x));
    }
    problem.in["position"] = p.vectors(p.position);
    const Values out =
        run_kernel<kernels::deformation::Args>(OpenDevices::of(GetParam()), p.count, problem.in);
    std::size_t checked = 0;
    for (std::size_t i = 0; i < p.count; ++i) {
      const Matrix3 f = gradient_of(out, p.first + i);
      ASSERT_TRUE(f.allFinite()) << i;
      Matrix3 xx = Matrix3::Zero();
      for (const auto& bond : p.bonds[i]) {
        const Vector3& xi = bond.reference;
        if (std::abs(xi.z()) > p.unit || (rod && std::abs(xi.y()) > p.unit)) continue;
        xx += bond.out * xi * xi.transpose();
      }
      const Vector3 spread = Eigen::JacobiSVD<Matrix3>(xx).singularValues();
      if (!(spread[rod ? 0 : 1] > 0.1 * spread.sum())) continue; // fewer directions still
      ++checked;
      EXPECT_LT((f.col(0) - 1.2 * turn.col(0)).norm(), 5e-3) << "particle " << i;
      if (rod) // its direction is all that is known of the rotation: the rest is some right-handed frame
        EXPECT_NEAR(f.determinant(), 1.2, 0.01) << "particle " << i;
      else
        EXPECT_LT((f.col(2) - turn.col(2)).norm(), 5e-3) << "the normal of the turned sheet, particle " << i;
    }
    EXPECT_GT(checked, p.count / 5);
  }
}

TEST_P(Deformation, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::deformation::Args>(GetParam(), Problem(129, nullptr), {"position", 4, 1},
                                                   {"gradient", 12});
}

} // namespace
} // namespace pliant::test
