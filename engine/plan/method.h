// Which global step a scene is solved with.
//
//   jacobi, chebyshev   one pass over the particles an iteration; guarded
//   position            the average of what neighbourhoods ask for, as position-based dynamics does
//   direct              the constant matrix, factorised once, on the host
//   lbfgs               the same matrix, or what stands for it, and the last five steps
//   newton              conjugate gradients on the exact derivative
//   auto                one of these, by stiffness number, Poisson's ratio and tolerance
#pragma once

#include "engine/model/model.h"

#include <span>
#include <string>

namespace pliant {

struct Scene;

/// A method resolved: never "auto".
struct Method {
  std::string name;
  std::string preconditioner; ///< "diagonal", "multilevel", "direct"; empty where the method has none
  std::string reason;         ///< why auto chose it; empty where the scene named it
  double stiffness_number = 0;
  bool line_search = false;    ///< evaluates and cuts steps
  bool potential = false;      ///< every term of the scene derives from one
  double energy_tolerance = 0; ///< what ends a step; 0: the residual's tolerance does
};

/// Throws Error(usage) where the scene names a method that its law does not have.
Method choose_method(const Scene& scene, const Model& model);

std::span<const char* const> method_names();         ///< with "auto"
std::span<const char* const> preconditioner_names(); ///< with "auto"

} // namespace pliant
