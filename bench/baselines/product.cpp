// Pliant itself behind the interface of the baselines: in double, on one thread, solved as its scene says.
#include "bench/baselines/baseline.h"

#include "engine/solver/simulation.h"

#include <cmath>

namespace pliant::bench {
namespace {

class Product : public Baseline {
public:
  Product(const Scene& scene, const Model& model)
      : Baseline(scene, model), own_scene_(scene),
        device_(open_device({"openmp", Precision::double_precision, 1, false})) {}

protected:
  void step(double h) override {
    if (h != own_step_) start(h);
    simulation_->step();
    position_ = simulation_->positions();
    velocity_ = simulation_->velocities();
  }
  void scale_velocities(double factor) override {
    Baseline::scale_velocities(factor);
    Snapshot state = simulation_->snapshot();
    state.velocity = velocity_;
    simulation_->restore(state);
  }

private:
  /// A frame is one step, so that the step is not shortened; a later step length goes on from the state.
  void start(double h) {
    own_scene_.simulation.time_step = h;
    own_scene_.output.fps = 1 / h;
    PlanRequest request;
    request.statistics = false;
    auto next = std::make_unique<Simulation>(*device_, own_scene_, model_, request);
    if (simulation_) {
      Snapshot state = simulation_->snapshot();
      state.step = static_cast<std::uint64_t>(std::llround(time_ / h));
      next->restore(state);
    }
    simulation_ = std::move(next);
    own_step_ = h;
  }

  Scene own_scene_;
  double own_step_ = 0;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Simulation> simulation_;
};

} // namespace

std::unique_ptr<Baseline> make_product(const Scene& scene, const Model& model) {
  return std::make_unique<Product>(scene, model);
}

} // namespace pliant::bench
