// Moment-matched weights: min a^2 |A w - b|^2 + e^2 sum (w - w0)^2 / w0,  sum w = 1,  w >= 0.
//
// With D = diag(w0), B = [A; 1] and the free (positive) set F, the stationary point is
//   w = w0 + D B^T z,   (B_F D_F B_F^T + diag(d, .., d, 0)) z = [b; 1] - B_F w0_F,   d = (e / a)^2,
// a system of 7 or 16 unknowns (4 or 6 in two dimensions) however many neighbours there are. Which weights
// are positive is found by a primal active-set method from w0. Where the moments can be met exactly on that
// set, d = 0 meets them to rounding: the trace of A's rows is the sum of the weights, so the row of ones is
// then implied.
#include "engine/model/moments.h"

#include "engine/core/error.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant {

namespace {

/// (e / a)^2 of the fourth moments; a / e = 100 leaves the weights some freedom where they cannot be met
/// anyway.
constexpr double fourth_slack = 1e-4;
/// Second moments can nearly always be met, so the slack only keeps the system regular: a / e = 3000.
constexpr double second_slack = 1e-7;
/// Moments count as met below this; rounding leaves a few 1e-16.
constexpr double met = 3e-15;
/// Eigenvalues of A D A^T below this share of the largest are directions that these neighbours do not span.
constexpr double rank_cut = 1e-11;

/// Distinct components of a symmetric tensor of rank 2 or 4, each scaled by the root of its multiplicity, so
/// that the vector's norm is the tensor's.
template <int rows> using Moments = Eigen::Matrix<double, rows, 1>;

void evaluate(const Vector3& n, Moments<6>& a) {
  const double root = std::sqrt(2.0);
  a << n.x() * n.x(), n.y() * n.y(), n.z() * n.z(), root * n.x() * n.y(), root * n.y() * n.z(),
      root * n.x() * n.z();
}

void evaluate(const Vector3& n, Moments<15>& a) {
  const double root4 = 2, root6 = std::sqrt(6.0), root12 = std::sqrt(12.0);
  const double x = n.x(), y = n.y(), z = n.z(), xx = x * x, yy = y * y, zz = z * z;
  a << xx * xx, yy * yy, zz * zz, root6 * xx * yy, root6 * yy * zz, root6 * zz * xx, root4 * xx * x * y,
      root4 * xx * x * z, root4 * yy * y * x, root4 * yy * y * z, root4 * zz * z * x, root4 * zz * z * y,
      root12 * xx * y * z, root12 * yy * z * x, root12 * zz * x * y;
}

/// In two dimensions, of directions with n_z = 0.
void evaluate(const Vector3& n, Moments<3>& a) {
  a << n.x() * n.x(), n.y() * n.y(), std::sqrt(2.0) * n.x() * n.y();
}

void evaluate(const Vector3& n, Moments<5>& a) {
  const double x = n.x(), y = n.y(), xx = x * x, yy = y * y;
  a << xx * xx, yy * yy, std::sqrt(6.0) * xx * yy, 2 * xx * x * y, 2 * yy * y * x;
}

/// Averages over the sphere: <n_x^2> = 1/3; <n_x^4> = 1/5, <n_x^2 n_y^2> = 1/15.
void target(Moments<6>& b) {
  b << 1. / 3, 1. / 3, 1. / 3, 0, 0, 0;
}

void target(Moments<15>& b) {
  b.setZero();
  b.head<3>().setConstant(1. / 5);
  b.segment<3>(3).setConstant(std::sqrt(6.0) / 15);
}

/// Averages over the circle: <n_x^2> = 1/2; <n_x^4> = 3/8, <n_x^2 n_y^2> = 1/8.
void target(Moments<3>& b) {
  b << 1. / 2, 1. / 2, 0;
}

void target(Moments<5>& b) {
  b << 3. / 8, 3. / 8, std::sqrt(6.0) / 8, 0, 0;
}

/// Directions of bonds in three dimensions.
std::vector<Vector3> directions(std::span<const GridVector> vectors) {
  std::vector<Vector3> found;
  found.reserve(vectors.size());
  for (const GridVector& v : vectors)
    found.push_back(Vector3(v[0], v[1], v[2]) / std::sqrt(static_cast<double>(squared_length(v))));
  return found;
}

/// The same laid into the plane nearest to the bonds, as angles about its normal: z is zero.
std::vector<Vector3> flat_directions(std::span<const GridVector> vectors) {
  Matrix3 spread = Matrix3::Zero();
  for (const GridVector& v : vectors) {
    const Vector3 x(v[0], v[1], v[2]);
    spread += x * x.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(spread);
  std::vector<Vector3> found = directions(vectors);
  for (Vector3& n : found) {
    const Vector3 flat(eigen.eigenvectors().col(2).dot(n), eigen.eigenvectors().col(1).dot(n), 0);
    const double length = flat.norm(); // zero: upright in the plane's middle, which no sheet has
    n = length > 0 ? Vector3(flat / length) : Vector3(1, 0, 0);
  }
  return found;
}

template <int rows> class Matching {
public:
  Matching(std::span<const GridVector> vectors, const Influence& influence)
      : count_(vectors.size()), moments_(rows, count_) {
    target(target_);
    base_.resize(static_cast<Eigen::Index>(count_));
    const std::vector<Vector3> along = rows <= 5 ? flat_directions(vectors) : directions(vectors);
    Moments<rows> column;
    for (std::size_t k = 0; k < count_; ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double length = std::sqrt(static_cast<double>(squared_length(vectors[k])));
      evaluate(along[k], column);
      moments_.col(at) = column;
      base_[at] = influence(length / reference_grid);
    }
    base_ /= base_.sum();
    weight_ = base_;
    free_.assign(count_, true);
  }

  void match() {
    if (meet_exactly(false)) return;
    descend(rows == 6 || rows == 3 ? second_slack : fourth_slack);
    meet_exactly(true);
  }

  NeighbourhoodWeights result() const {
    NeighbourhoodWeights answer;
    answer.weight.assign(weight_.data(), weight_.data() + weight_.size());
    answer.residual = (moments_ * weight_ - target_).norm() / target_.norm();
    return answer;
  }

private:
  /// The weights nearest to the base on the free set whose moments are the target's; false where there are
  /// none that are non-negative. With `shrink`, weights that come out negative leave the set, and it tries
  /// again.
  bool meet_exactly(bool shrink) {
    std::vector<bool> free = free_;
    for (std::size_t round = 0; round <= count_; ++round) {
      Eigen::Matrix<double, rows, rows> normal = Eigen::Matrix<double, rows, rows>::Zero();
      Eigen::VectorXd weight = Eigen::VectorXd::Zero(base_.size());
      for (Eigen::Index k = 0; k < base_.size(); ++k) {
        if (!free[k]) continue;
        weight[k] = base_[k];
        normal.noalias() += base_[k] * moments_.col(k) * moments_.col(k).transpose();
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, rows, rows>> eigen(normal);
      Moments<rows> inverse = eigen.eigenvalues();
      const double cut = rank_cut * inverse.maxCoeff();
      for (double& value : inverse) value = value > cut ? 1 / value : 0;
      Moments<rows> miss;
      for (int refinement = 0; refinement < 3; ++refinement) {
        miss = target_ - moments_ * weight;
        const Moments<rows> y =
            eigen.eigenvectors() * inverse.cwiseProduct(eigen.eigenvectors().transpose() * miss);
        for (Eigen::Index k = 0; k < base_.size(); ++k)
          if (free[k]) weight[k] += base_[k] * moments_.col(k).dot(y);
      }
      miss = target_ - moments_ * weight;
      if (!(miss.norm() <= met)) return false;
      if (weight.minCoeff() >= 0) {
        weight_ = weight;
        return true;
      }
      if (!shrink) return false;
      for (Eigen::Index k = 0; k < base_.size(); ++k)
        if (weight[k] < 0) free[k] = false;
    }
    return false;
  }

  /// The active-set method. The objective is strictly convex, so each set is met once; the cap only guards
  /// rounding.
  void descend(double slack) {
    using System = Eigen::Matrix<double, rows + 1, rows + 1>;
    using Column = Eigen::Matrix<double, rows + 1, 1>;
    const auto column = [this](Eigen::Index k) {
      Column c;
      c << moments_.col(k), 1;
      return c;
    };
    System system = System::Zero();
    system.diagonal().template head<rows>().setConstant(slack);
    Column right;
    right << target_, 1;
    const auto change = [&](Eigen::Index k, double sign) {
      const Column c = column(k);
      system.noalias() += sign * base_[k] * c * c.transpose();
      right -= sign * base_[k] * c;
    };
    for (Eigen::Index k = 0; k < base_.size(); ++k) change(k, 1);
    Eigen::VectorXd wanted(base_.size());
    for (std::size_t iteration = 0; iteration < 10 * count_ + 20; ++iteration) {
      const Column z = Eigen::LDLT<System>(system).solve(right);
      for (Eigen::Index k = 0; k < base_.size(); ++k) wanted[k] = base_[k] * (1 + column(k).dot(z));
      // The longest step towards the stationary point that keeps the weights non-negative.
      double step = 1;
      Eigen::Index blocking = -1;
      for (Eigen::Index k = 0; k < base_.size(); ++k) {
        if (!free_[k] || wanted[k] >= 0) continue;
        const double reach = weight_[k] / (weight_[k] - wanted[k]);
        if (blocking < 0 || reach < step) {
          step = std::min(step, reach);
          blocking = k;
        }
      }
      for (Eigen::Index k = 0; k < base_.size(); ++k)
        if (free_[k]) weight_[k] = std::max(0.0, weight_[k] + step * (wanted[k] - weight_[k]));
      if (blocking >= 0) {
        weight_[blocking] = 0;
        free_[blocking] = false;
        change(blocking, -1);
        continue;
      }
      // Stationary: `wanted` of a weight held at zero says whether it would rather grow.
      Eigen::Index eager = -1;
      for (Eigen::Index k = 0; k < base_.size(); ++k)
        if (!free_[k] && wanted[k] > 1e-9 * base_[k] && (eager < 0 || wanted[k] > wanted[eager])) eager = k;
      if (eager < 0) break;
      free_[eager] = true;
      change(eager, 1);
    }
    weight_ /= weight_.sum();
  }

  std::size_t count_;
  Eigen::Matrix<double, rows, Eigen::Dynamic> moments_; ///< A
  Moments<rows> target_;                                ///< b
  Eigen::VectorXd base_, weight_;                       ///< w0, w
  std::vector<bool> free_;                              ///< weights that may be positive
};

template <int rows>
NeighbourhoodWeights solve(std::span<const GridVector> vectors, const Influence& influence, bool matched) {
  Matching<rows> matching(vectors, influence);
  if (matched) matching.match();
  return matching.result();
}

} // namespace

NeighbourhoodWeights neighbourhood_weights(std::span<const GridVector> vectors, const Influence& influence,
                                           int order, bool matched, int dimension) {
  if (vectors.empty()) return {};
  if (dimension == 2)
    return order == 2 ? solve<3>(vectors, influence, matched) : solve<5>(vectors, influence, matched);
  return order == 2 ? solve<6>(vectors, influence, matched) : solve<15>(vectors, influence, matched);
}

double Influence::operator()(double r) const {
  switch (kind) {
  case Kind::power:
    return std::pow(r, exponent);
  case Kind::constant:
    return 1;
  case Kind::decreasing:
    return 1 / (1 + r / horizon);
  case Kind::increasing:
    return r / horizon;
  }
  return 1;
}

Influence influence_of(const SimulationSettings& simulation, double horizon) {
  if (simulation.influence == "power") return simulation.weight_exponent;
  if (simulation.influence == "constant") return {Influence::Kind::constant, horizon};
  if (simulation.influence == "decreasing") return {Influence::Kind::decreasing, horizon};
  if (simulation.influence == "increasing") return {Influence::Kind::increasing, horizon};
  throw Error(ExitCode::usage,
              "the influence is \"power\", \"constant\", \"decreasing\" or \"increasing\", not \"" +
                  simulation.influence + "\"");
}

} // namespace pliant
