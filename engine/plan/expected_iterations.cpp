// Estimates iteration counts.
#include "engine/plan/expected_iterations.h"

#include <algorithm>
#include <cmath>

namespace pliant {

double expected_iterations(const Method& method, double tolerance) {
  const double eta = method.stiffness_number, digits = -std::log10(std::min(tolerance, 0.1));
  const double sweeps = std::max(1.0, std::sqrt(eta / 2) * std::log(2 / tolerance));
  if (method.name == "jacobi" || method.name == "position")
    return std::max(1.0, eta * std::log(1 / tolerance));
  if (method.name == "chebyshev") return sweeps;
  const double growth = std::log10(10 + eta); // of steps, with how far a stiff body's shape changes in one
  if (method.preconditioner == "multilevel")
    return std::min(sweeps, (method.name == "newton" ? 4 : 8) * digits * growth);
  if (method.preconditioner == "direct") return (method.name == "lbfgs" ? 4 : 40) * digits * growth;
  return std::min(sweeps, 20 * digits * growth * growth);
}

} // namespace pliant
