// The step that explicit methods share, and the one that integrates Pliant's own force: what the implicit
// solve buys. The bound 2 m / K > h^2, that is a stiffness number below 2, is on the safe side of the step
// that power iteration finds.
#include "bench/baselines/explicit.h"

#include "engine/solver/simulation.h"

#include <cmath>
#include <random>

namespace pliant::bench {

void ExplicitIntegration::step(double h) {
  const Points force = forces(position_);
  for (std::size_t i = 0; i < position_.size(); ++i) {
    if (held(i, time_ + h)) {
      const Vector3 next = prescribed(i, time_ + h);
      velocity_[i] = (next - position_[i]) / h;
      position_[i] = next;
    } else {
      velocity_[i] += h / model_.mass[i] * (force[i] + external_force(i, time_));
      position_[i] += h * velocity_[i];
    }
  }
  collide(h);
}

double ExplicitIntegration::stable_step() {
  constexpr int rounds = 200;
  const double size = 1e-5 * model_.spacing;
  std::mt19937 random(5);
  const std::size_t count = model_.count();
  Points v(count), up(count), down(count);
  for (Vector3& x : v)
    for (int k = 0; k < 3; ++k) x[k] = static_cast<double>(random()) / 2147483648.0 - 1;
  double squared = 0; // the frequency's
  for (int round = 0; round < rounds; ++round) {
    double largest = 0, vv = 0, vkv = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (held(i, 0)) v[i].setZero();
      largest = std::max(largest, v[i].norm());
    }
    if (!(largest > 0)) break;
    for (std::size_t i = 0; i < count; ++i) {
      v[i] *= size / largest;
      up[i] = model_.reference[i] + v[i], down[i] = model_.reference[i] - v[i];
    }
    const Points a = forces(up), b = forces(down);
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 kv = held(i, 0) ? Vector3(Vector3::Zero()) : Vector3((b[i] - a[i]) / 2);
      vv += model_.mass[i] * v[i].squaredNorm(), vkv += v[i].dot(kv);
      v[i] = kv / model_.mass[i];
    }
    squared = vkv / vv;
  }
  return squared > 0 ? 2 / std::sqrt(squared) : std::numeric_limits<double>::infinity();
}

namespace {

class PliantForce : public ExplicitIntegration {
public:
  PliantForce(const Scene& scene, const Model& model)
      : ExplicitIntegration(scene, model), own_scene_(scene),
        device_(open_device({"openmp", Precision::double_precision, 1, false})) {
    own_scene_.solver.method = "chebyshev"; // it solves nothing: the one that prepares least
    simulation_ = std::make_unique<Simulation>(*device_, own_scene_, model);
  }
  Points forces(const Points& y) override { return simulation_->elastic_forces(y); }

private:
  Scene own_scene_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Simulation> simulation_;
};

} // namespace

std::unique_ptr<Baseline> make_explicit(const Scene& scene, const Model& model) {
  return std::make_unique<PliantForce>(scene, model);
}

} // namespace pliant::bench
