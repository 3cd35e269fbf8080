// Shape matching (Müller, Heidelberger, Teschner and Gross 2005) with a rigid cluster a particle: itself and
// its bonded neighbours, as overlapping regions are matched by Rivers and James (2007). Each step moves
// particles by inertia and gravity, matches each cluster's rest shape to where its particles are,
//
//   A = sum of m (y - c) (x - c0)^T,  R its rotation,  goal = R (x - c0) + c,
//
// and moves each particle to the mean of its goals (their stiffness alpha = 1). A particle's mass is shared
// among its clusters, which conserves both momenta. There is no modulus: the stiffness is of order m / h^2,
// so it depends on the time step, and there is no Poisson's ratio either.
#include "bench/baselines/baseline.h"

namespace pliant::bench {
namespace {

class ShapeMatching : public Baseline {
public:
  ShapeMatching(const Scene& scene, const Model& model) : Baseline(scene, model), share_(model.count()) {
    for (std::uint32_t i = 0; i < model.count(); ++i) // bonds are symmetric: in as many clusters as it has
      share_[i] = model.mass[i] / (1 + model.bonds.begin[i + 1] - model.bonds.begin[i]);
  }

protected:
  void step(double h) override {
    const Points target = inertial_target(h);
    Points next(target.size(), Vector3::Zero());
    for (std::uint32_t i = 0; i < target.size(); ++i) {
      double mass = 0;
      Vector3 c = Vector3::Zero(), c0 = Vector3::Zero();
      each_member(i, [&](std::uint32_t k) {
        mass += share_[k];
        c += share_[k] * target[k];
        c0 += share_[k] * model_.reference[k];
      });
      c /= mass, c0 /= mass;
      Matrix3 a = Matrix3::Zero();
      each_member(i, [&](std::uint32_t k) {
        a += share_[k] * (target[k] - c) * (model_.reference[k] - c0).transpose();
      });
      const Matrix3 rotation = signed_rotation(a);
      each_member(i, [&](std::uint32_t k) {
        next[k] += share_[k] / model_.mass[k] * (rotation * (model_.reference[k] - c0) + c);
      });
    }
    for (std::size_t i = 0; i < next.size(); ++i)
      if (held(i, time_ + h)) next[i] = target[i];
    take(next, h);
    collide(h);
  }

private:
  template <class Function> void each_member(std::uint32_t i, const Function& function) const {
    function(i);
    for (std::uint32_t b = model_.bonds.begin[i]; b < model_.bonds.begin[i + 1]; ++b)
      function(model_.bonds.neighbour[b]);
  }

  std::vector<double> share_; // kg: of a particle's mass, in each of its clusters
};

} // namespace

std::unique_ptr<Baseline> make_shape_matching(const Scene& scene, const Model& model) {
  return std::make_unique<ShapeMatching>(scene, model);
}

} // namespace pliant::bench
