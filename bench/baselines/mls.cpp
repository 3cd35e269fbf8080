// Meshless elasticity with a rotation taken out explicitly. The deformation gradient is the moving-least-
// squares fit of Müller, Keiser, Nealen, Pauly, Gross and Alexa (2004, section 3),
//
//   F_i = <Y X^T> <X X^T>^-1,
//
// its rotation R is extracted by a singular value decomposition, as in the method of Jones, Ward, Jallepalli,
// Perenia and Bargteil (2014) that Fig. 1 compares with, and linear elasticity acts on S - I, S = R^T F:
//
//   W = mu |S - I|^2 + (lambda / 2) tr^2(S - I),  P = R (2 mu (S - I) + lambda tr(S - I) I).
//
// Forces are V_i w_ij P <X X^T>^-1 X on bonds, both ends, integrated explicitly. F sees of the neighbourhood
// only what is affine: the rest, and a neighbourhood without volume at rest, meets no force.
#include "bench/baselines/explicit.h"

#include <Eigen/Eigenvalues>

namespace pliant::bench {
namespace {

class MovingLeastSquares : public ExplicitIntegration {
public:
  MovingLeastSquares(const Scene& scene, const Model& model)
      : ExplicitIntegration(scene, model), inverse_(model.count(), Matrix3::Zero()) {
    for (std::uint32_t i = 0; i < model.count(); ++i) {
      Matrix3 moment = Matrix3::Zero();
      each_bond(i, [&](std::uint32_t, const Vector3& x, double w) { moment += w * x * x.transpose(); });
      const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(moment);
      if (eigen.eigenvalues()[0] > 1e-4 * moment.trace()) inverse_[i] = moment.inverse();
    }
  }

  Points forces(const Points& y) override {
    Points force(y.size(), Vector3::Zero());
    for (std::uint32_t i = 0; i < y.size(); ++i) {
      if (inverse_[i].isZero(0)) continue;
      const Material& material = typed_material(scene_, model_, i);
      const double mu = material.young / (2 * (1 + material.poisson));
      const double lambda = 2 * mu * material.poisson / (1 - 2 * material.poisson);
      Matrix3 f = Matrix3::Zero();
      each_bond(i,
                [&](std::uint32_t j, const Vector3& x, double w) { f += w * (y[j] - y[i]) * x.transpose(); });
      f = f * inverse_[i];
      if (!f.allFinite()) continue; // gone already: the run says so
      const Matrix3 rotation = signed_rotation(f);
      const Matrix3 strain = rotation.transpose() * f - Matrix3::Identity();
      const Matrix3 stress =
          rotation * (2 * mu * strain + lambda * strain.trace() * Matrix3::Identity()) * inverse_[i];
      each_bond(i, [&](std::uint32_t j, const Vector3& x, double w) {
        const Vector3 pull = model_.volume[i] * w * (stress * x);
        force[i] += pull, force[j] -= pull;
      });
    }
    return force;
  }

private:
  template <class Function> void each_bond(std::uint32_t i, const Function& function) const {
    for (std::uint32_t b = model_.bonds.begin[i]; b < model_.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model_.bonds.neighbour[b];
      function(j, Vector3(model_.reference[j] - model_.reference[i]), model_.bonds.weight[b]);
    }
  }

  std::vector<Matrix3> inverse_; // 1/m2; zero where the neighbourhood has no volume
};

} // namespace

std::unique_ptr<Baseline> make_mls(const Scene& scene, const Model& model) {
  return std::make_unique<MovingLeastSquares>(scene, model);
}

} // namespace pliant::bench
