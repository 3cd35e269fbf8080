// See kernels/conjugate_control.decl.
#include "kernels/conjugate_control.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/energy_error.glsl"
#include "shaders/common/solver.glsl"
#include "shaders/common/trust_region.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// What the last step's success makes of the region.
template <class real> PLIANT_INLINE void choose_radius(real* solver, bool potential) {
  const real length = solver[SOLVER_LENGTH], edge = solver[SOLVER_EDGE];
  const real kept = solver[SOLVER_LAST_FALL], promised = solver[SOLVER_PROMISE];
  solver[SOLVER_EDGE] = 0;
  if (solver[SOLVER_CAUTIOUS] > 0) {
    solver[SOLVER_RADIUS] = 0;
  } else if (edge > 0) {
    if (length < 1)
      solver[SOLVER_RADIUS] = length * root(solver[SOLVER_STEP2]);
    else if (potential && kept < real(TRUST_LEAST) * promised)
      solver[SOLVER_RADIUS] = root(solver[SOLVER_STEP2]) / 2;
    else if (edge > 1 && !(potential && kept < real(TRUST_MOST) * promised))
      solver[SOLVER_RADIUS] *= 2;
  }
}

/// How far along the direction the region's edge is: the positive root of |d + t p|^2 = radius^2.
template <class real> PLIANT_INLINE real way_to_edge(const real* solver) {
  const real radius = solver[SOLVER_RADIUS], a = solver[SOLVER_DIRECTION2], b = solver[SOLVER_STEP_ALONG];
  const real left = larger(radius * radius - solver[SOLVER_STEP2], real(0));
  const real below = b + root(larger(b * b + a * left, real(0)));
  return below > 0 ? left / below : real(0);
}

} // namespace

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
    const bool bounded = solver[SOLVER_RADIUS] > 0 && __builtin_isfinite(found);
    const real edge = bounded ? way_to_edge(solver) : real(0);
    if (bounded && !(usable && rz / found < edge)) {
      if (usable && k.energy_tolerance > 0)
        solver[SOLVER_GAIN] =
            larger(solver[SOLVER_GAIN],
                   larger(rz / found, (solver[SOLVER_SLOPE] + rz / found * rz) / solver[SOLVER_RZ_FIRST]));
      solver[SOLVER_CG_STEP] = edge;
      solver[SOLVER_SLOPE] += edge * rz;
      solver[SOLVER_PROMISE] += edge * (rz - edge * found / 2);
      solver[SOLVER_STEP2] = solver[SOLVER_RADIUS] * solver[SOLVER_RADIUS];
      solver[SOLVER_INNER] += 1;
      solver[SOLVER_EDGE] = 2;
      complete = true;
    } else if (usable) {
      const real step = rz / found;
      solver[SOLVER_STEP2] += step * (2 * solver[SOLVER_STEP_ALONG] + step * solver[SOLVER_DIRECTION2]);
      solver[SOLVER_PROMISE] += step * rz / 2;
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
      if (first) {
        solver[SOLVER_SLOPE] = solver[SOLVER_PROMISE] = rz;
        solver[SOLVER_STEP2] = solver[SOLVER_DIRECTION2];
      }
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
    choose_radius(solver, k.potential > 0);
    solver[SOLVER_STEP2] = solver[SOLVER_STEP_ALONG] = solver[SOLVER_PROMISE] = 0;
    solver[SOLVER_DIRECTION2] = found;
    solver[SOLVER_SLOPE] = 0;
    solver[SOLVER_CG_KEEP] = 0;
    solver[SOLVER_RZ] = found;
  } else if (found > solver[SOLVER_RZ_ENOUGH] && solver[SOLVER_COUNT] < static_cast<real>(k.cap) &&
             !(k.energy_tolerance > 0 &&
               2 * solver[SOLVER_GAIN] * found <=
                   k.energy_tolerance * (solver[SOLVER_FALL] + solver[SOLVER_SLOPE] / 2))) {
    const real keep = found / solver[SOLVER_RZ], along = solver[SOLVER_STEP_ALONG];
    solver[SOLVER_STEP_ALONG] = keep * (along + solver[SOLVER_CG_STEP] * solver[SOLVER_DIRECTION2]);
    solver[SOLVER_DIRECTION2] = found + keep * keep * solver[SOLVER_DIRECTION2];
    solver[SOLVER_CG_KEEP] = keep;
    solver[SOLVER_RZ] = found;
  } else {
    complete = true;
  }
  solver[SOLVER_ACTION] = complete ? real(2) : real(1);
  if (complete) {
    solver[SOLVER_LINEAR] = 0;
    solver[SOLVER_STOP] = 0;
    solver[SOLVER_LENGTH] = 1;
    solver[SOLVER_EDGE] = larger(solver[SOLVER_EDGE], real(1));
  }
}

PLIANT_BODY(conjugate_control)

} // namespace pliant::openmp::PLIANT_ISA
