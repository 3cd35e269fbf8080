// The constant matrix A = M / h^2 + L of projective dynamics (He, Wang and Wu 2017, section 4.2), factorised
// on the host in double whenever the step changes its length; solved with on the device, in its precision.
#pragma once

#include "engine/solver/cholesky.h"
#include "engine/solver/preconditioner.h"

#include <map>
#include <string>

namespace pliant {

/// What solving with the factor needs. Throws Error(too_large) where the factor would not fit in memory.
struct DirectPlan {
  Dissection dissection;
  FactorLayout layout;
  std::vector<BufferSpec> buffers;
  std::vector<KernelSpec> kernels;
};
DirectPlan plan_direct(const Model& model);

class Direct : public Preconditioner {
public:
  /// Factorises for the scene's own step.
  explicit Direct(const SolveContext& context);
  /// Factorises when the step is another one than before.
  void begin(const SolveBounds& bounds) override;
  void apply() override;

private:
  void factorise_for(double step);
  BufferStorage* at(const std::string& name) const;

  const DirectPlan& plan_;
  std::map<std::string, Buffer> buffers_;
  double step_ = 0;
};

} // namespace pliant
