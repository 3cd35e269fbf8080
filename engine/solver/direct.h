// The constant matrix A = M / h^2 + L of projective dynamics (He, Wang and Wu 2017, section 4.2), factorised
// once in double on the CPU, whatever the precision of the state: CHOLMOD's supernodal Cholesky where this
// build has it, Eigen's simplicial one elsewhere.
#pragma once

#include "engine/solver/preconditioner.h"

namespace pliant {

class Direct : public Preconditioner {
public:
  /// Throws Error(usage) on a device that is not the CPU.
  explicit Direct(const SolveContext& context);
  ~Direct() override;
  /// Factorises when the step is another one than before. Throws Error(too_large), with the estimate, before
  /// it is tried, where the factor would not fit in memory.
  void begin(const SolveBounds& bounds) override;
  void apply() override;

  /// "CHOLMOD" or "Eigen".
  static const char* library();

private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
  std::vector<bool> held_;
  double step_ = 0;
};

} // namespace pliant
