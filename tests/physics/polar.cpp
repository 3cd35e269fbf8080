// The rotation that corotated_state finds, on every device, against Eigen's singular value decomposition:
// random, stretched, inverted, nearly singular and rank-deficient matrices. A particle without bonds keeps
// the matrix that `shape` gives it, so the kernel can be asked directly.
#include "kernels/corotated_state.h"
#include "shaders/common/solver.glsl"
#include "tests/support/bodies.h"

#include <Eigen/SVD>

namespace pliant::test {
namespace {

Matrix3 random_rotation(std::mt19937& random) {
  Eigen::Vector4d q;
  do {
    q << random_vector(random), random_vector(random).x();
  } while (q.norm() < 0.1 || q.norm() > 1);
  return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
}

struct Case {
  const char* name;
  bool unique; ///< sum of the two smallest signed values is not small
  std::vector<Matrix3> matrices;
};

std::vector<Case> cases() {
  std::mt19937 random(101);
  const struct {
    const char* name;
    Vector3 values;
    bool unique;
  } kinds[] = {{"rotations", {1, 1, 1}, true},
               {"stretched", {2, 1, 0.5}, true},
               {"strongly stretched", {30, 1, 0.2}, true},
               {"inverted", {1.3, 0.9, -0.4}, true},
               {"flat", {1.1, 0.8, 0}, true},
               {"nearly flat", {1.1, 0.8, 1e-6}, true},
               {"tiny", {2e-4, 1e-4, 1e-4}, true},
               {"line", {1.2, 0, 0}, false},
               {"nearly a line", {1.2, 1e-3, -1e-4}, true},
               {"point", {0, 0, 0}, false},
               {"mirror image", {1, 1, -1}, false},
               {"mirrored, equal smallest", {1.5, 0.7, -0.7}, false}};
  std::vector<Case> result;
  for (const auto& kind : kinds) {
    Case made{kind.name, kind.unique, {}};
    for (int k = 0; k < 64; ++k)
      made.matrices.push_back(random_rotation(random) * kind.values.asDiagonal() * random_rotation(random));
    result.push_back(made);
  }
  Case gauss{"random entries", false, {}};
  for (int k = 0; k < 512; ++k) {
    Matrix3 a;
    for (int c = 0; c < 3; ++c) a.col(c) = random_vector(random);
    gauss.matrices.push_back(a);
  }
  result.push_back(gauss);
  return result;
}

/// Rotations of the matrices, each sought from a start of its own.
std::vector<Matrix3> rotations(Device& device, const std::vector<Matrix3>& matrices, unsigned seed) {
  const std::size_t n = matrices.size(), slices = (n + 15) / 16;
  std::mt19937 random(seed);
  std::vector<double> shape(11 * n);
  std::vector<Real4<double>> start(n);
  for (std::size_t i = 0; i < n; ++i) {
    shape[i] = 1;     // 1 / modulus
    shape[n + i] = 0; // coupling: the record is the rotation itself
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 3; ++c)
        shape[(3 * r + c + 2) * n + i] =
            matrices[i](static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
    const Eigen::Quaterniond q(random_rotation(random));
    start[i] = {q.x(), q.y(), q.z(), q.w()};
  }
  Buffer slice_begin = device.allocate("slice_begin", Type::uint, slices + 1),
         bond = device.allocate("bond", Type::uint, 32), weight = device.allocate("weight", Type::real, 32),
         displacement = device.allocate("displacement", Type::real4, n),
         shapes = device.allocate("shape", Type::real, 11 * n),
         rotation = device.allocate("rotation", Type::real4, n),
         record = device.allocate("record", Type::real4, 3 * n),
         solver = device.allocate("solver", Type::real, SOLVER_ENTRIES);
  device.upload(shapes, shape);
  device.upload(rotation, start);
  device.run(kernels::corotated_state::Args{.threads = static_cast<std::uint32_t>(n),
                                            .first = 0,
                                            .first_slice = 0,
                                            .stride = static_cast<std::uint32_t>(n),
                                            .unit = 1,
                                            .slice_begin = slice_begin,
                                            .bond = bond,
                                            .weight = weight,
                                            .displacement = displacement,
                                            .shape = shapes,
                                            .rotation = rotation,
                                            .record = record,
                                            .solver = solver});
  std::vector<Matrix3> result;
  for (const Real4<double>& q : device.download_real4(rotation)) {
    EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 1e-5);
    result.push_back(Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix());
  }
  return result;
}

class Polar : public OnEachDevice {};

// tr(R^T S) is stationary at the answer, so it is right to the square of R's error; its limit is some
// roundings of |S|. R itself is as ill-conditioned as the gap, the sum of the two smallest signed values, is
// small: its error is some roundings times |S| over the gap.
TEST_P(Polar, RotationsAreThoseOfTheSingularValueDecomposition) {
  const auto open = device();
  const double epsilon = GetParam().epsilon(), bias = limit(1e-13, 1e-5);
  const double allowed = 64 * epsilon + std::sqrt(2.0) * bias;
  for (const Case& each : cases())
    for (const unsigned seed : {1u, 2u}) {
      const std::vector<Matrix3> found = rotations(*open, each.matrices, seed);
      double trace = 0, rotation = 0;
      for (std::size_t i = 0; i < found.size(); ++i) {
        const Matrix3& s = each.matrices[i];
        const Eigen::JacobiSVD<Matrix3> svd(s, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const double sign = determinant(svd.matrixU() * svd.matrixV().transpose()) < 0 ? -1 : 1;
        const Vector3& sigma = svd.singularValues();
        const double best = sigma[0] + sigma[1] + sign * sigma[2], gap = sigma[1] + sign * sigma[2];
        const double size = std::max(sigma[0], 1e-300);
        trace = std::max(trace, (best - found[i].cwiseProduct(s).sum()) / size);
        if (!each.unique) continue;
        const Matrix3 expected = svd.matrixU() * Vector3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
        rotation = std::max(rotation, (found[i] - expected).norm() * gap / size);
      }
      if (seed == 1 || trace > 32 * epsilon || rotation > allowed) {
        expect_below(std::string(each.name) + ": trace missed, of |S|", trace, 32 * epsilon);
        if (each.unique)
          expect_below(std::string(each.name) + ": error of R times gap / |S|", rotation, allowed);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Physics, Polar, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
