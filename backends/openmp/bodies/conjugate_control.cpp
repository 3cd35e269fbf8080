// See kernels/conjugate_control.decl.
#include "kernels/conjugate_control.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/energy_error.glsl"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void conjugate_control(const kernels::conjugate_control::View<real>& k) {
  Real4<real> sums{0, 0, 0, 0};
  for (uint p = 0; p < k.partial_count; ++p) {
    const auto part = k.solve_partial[p];
    sums = {sums.x + part.x, sums.y + part.y, sums.z + part.z, sums.w + part.w};
  }
  real* const solver = k.solver;
  solver[SOLVER_ACTION] = 0;
  if (solver[SOLVER_LINEAR] == 0) return;
  const real found = sums.x;
  const bool usable = found > 0 && __builtin_isfinite(found), first = solver[SOLVER_INNER] == 0;
  bool complete = false; // the next iteration evaluates the end of the whole step
  if (k.after) {
    const real rz = solver[SOLVER_RZ];
    solver[SOLVER_COUNT] += 1;
    if (usable) {
      const real step = rz / found;
      solver[SOLVER_CG_STEP] = step;
      solver[SOLVER_SLOPE] += step * rz; // r_first . p = r . z along conjugate directions
      solver[SOLVER_INNER] += 1;
      if (k.energy_tolerance > 0)
        solver[SOLVER_GAIN] =
            larger(solver[SOLVER_GAIN], larger(step, solver[SOLVER_SLOPE] / solver[SOLVER_RZ_FIRST]));
      complete = solver[SOLVER_COUNT] >= static_cast<real>(k.cap) || solver[SOLVER_CAUTIOUS] > 0;
    } else {
      solver[SOLVER_CONVEX] = solver[SOLVER_BEST];
      solver[SOLVER_CG_STEP] = first ? real(1) : real(0);
      if (first) solver[SOLVER_SLOPE] = rz;
      complete = true;
    }
  } else if (first) {
    const bool exhausted = solver[SOLVER_COUNT] >= static_cast<real>(k.cap);
    if (exhausted || !usable) { // the residual is zero, or no number
      solver[SOLVER_LINEAR] = 0;
      solver[SOLVER_STOP] = 1;
      solver[SOLVER_REASON] = exhausted ? real(3) : real(4);
      return;
    }
    if (k.energy_tolerance > 0) {
      const real left = solver[SOLVER_GAIN] * found;
      if (left > 0 && solver[SOLVER_FALL] > 0) {
        solver[SOLVER_ENERGY_ERROR] = left / (solver[SOLVER_FALL] + left);
        if (solver[SOLVER_ENERGY_ERROR] <= k.energy_tolerance) {
          solver[SOLVER_LINEAR] = 0;
          solver[SOLVER_STOP] = 1;
          solver[SOLVER_REASON] = 1;
          return;
        }
      }
      solver[SOLVER_RZ_FIRST] = found;
    }
    const real forcing = smaller(real(0.1), root(solver[SOLVER_BEST] / solver[SOLVER_FIRST]));
    solver[SOLVER_RZ_ENOUGH] = forcing * forcing * found;
    solver[SOLVER_SLOPE] = 0;
    solver[SOLVER_CG_KEEP] = 0;
    solver[SOLVER_RZ] = found;
  } else if (found > solver[SOLVER_RZ_ENOUGH] && solver[SOLVER_COUNT] < static_cast<real>(k.cap) &&
             !(k.energy_tolerance > 0 &&
               2 * solver[SOLVER_GAIN] * found <=
                   k.energy_tolerance * (solver[SOLVER_FALL] + solver[SOLVER_SLOPE] / 2))) {
    solver[SOLVER_CG_KEEP] = found / solver[SOLVER_RZ];
    solver[SOLVER_RZ] = found;
  } else {
    complete = true;
  }
  solver[SOLVER_ACTION] = complete ? real(2) : real(1);
  if (complete) {
    solver[SOLVER_LINEAR] = 0;
    solver[SOLVER_STOP] = 0;
    solver[SOLVER_LENGTH] = 1;
  }
}

PLIANT_BODY(conjugate_control)

} // namespace pliant::openmp::PLIANT_ISA
