// The stiffness number, and the step that frames allow.
#include "engine/solver/stiffness.h"

#include "engine/scene/scene.h"

#include <algorithm>
#include <cmath>

namespace pliant {

Stiffness stiffness_of(const Model& model, double step) {
  const std::vector<double> stiffness = diagonal_stiffness(model);
  std::vector<bool> held(model.count(), false);
  for (const Held& entry : model.held) held[entry.particle] = true;
  Stiffness result;
  for (std::size_t i = 0; i < model.count(); ++i) {
    if (held[i]) continue;
    const double inertia = model.mass[i] / (step * step);
    result.number = std::max(result.number, stiffness[i] / inertia);
    result.noise += stiffness[i] * stiffness[i] / (stiffness[i] + inertia);
  }
  result.noise = std::sqrt(result.noise);
  return result;
}

double whole_step(const Scene& scene) {
  const double frame = 1 / scene.output.fps;
  const double per_frame = std::ceil(frame / scene.simulation.time_step * (1 - 1e-9));
  return frame / std::max(per_frame, 1.0);
}

} // namespace pliant
