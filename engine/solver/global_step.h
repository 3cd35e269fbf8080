// The global step: how the forces at an iterate become a better iterate (He, Wang and Wu 2017, section 4.2).
//
//   Stationary    jacobi, chebyshev, position: one pass over the particles an iteration
//   Newton        newton: conjugate gradients on the exact derivative, then a step along what they found
//   QuasiNewton   lbfgs, direct: a direction from a constant matrix and from what earlier steps taught
//
// Whatever a method does, an iteration evaluates the problem at `displacement` first (local step, forces) and
// then calls apply(). What is decided inside a step is decided on the device; kernels that have nothing to do
// in an iteration return at once.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/plan.h"

#include <memory>

namespace pliant {

class Contacts;
class Elasticity;
struct SimulationState;

/// What a method sees of the simulation. All outlive it.
struct SolveContext {
  Device& device;
  const Scene& scene;
  const Model& model;
  const Plan& plan;
  SimulationState& state;
  Elasticity& elasticity;
  Contacts* contacts; ///< null where nothing can touch
};

/// One solve's numbers.
struct SolveBounds {
  double step = 0;             ///< h, or (2/3) h of BDF2, s
  double stiffness_number = 0; ///< eta
  double floor = 0;            ///< what the precision can reach near the start of the step, sqrt(N m)
  double rounding = 0;         ///< of a displacement, relative
  unsigned cap = 0;            ///< iterations
};

class GlobalStep {
public:
  explicit GlobalStep(const SolveContext& context) : context_(context) {}
  virtual ~GlobalStep() = default;
  GlobalStep(const GlobalStep&) = delete;
  GlobalStep& operator=(const GlobalStep&) = delete;

  /// Before the first iteration of a step.
  virtual void begin(const SolveBounds& bounds) = 0;
  /// Before iteration `k` whose problem is another one than before (a new set of contacts): what is computed
  /// next is the best iterate.
  virtual void restart() {}
  /// After the evaluation at `displacement`. `checked`: the stop flag is looked at after this one.
  virtual void apply(unsigned k, bool checked, bool restart) = 0;
  /// Iterations between two looks at the stop flag.
  virtual unsigned check_every() const = 0;

protected:
  SolveContext context_;
};

std::unique_ptr<GlobalStep> make_global_step(const SolveContext& context);

} // namespace pliant
