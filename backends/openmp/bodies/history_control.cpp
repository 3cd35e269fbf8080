// See kernels/history_control.decl.
#include "kernels/history_control.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/energy_error.glsl"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void history_control(const kernels::history_control::View<real>& k) {
  constexpr uint memory = MEMORY;
  real rz = 0, total[HISTORY_DOTS] = {};
  for (uint p = 0; p < k.partial_count; ++p) rz += k.solve_partial[p].x;
  real* const solver = k.solver;
  solver[SOLVER_ACTION] = 0;
  if (solver[SOLVER_LINEAR] == 0) return;
  if (!(rz > 0) || !__builtin_isfinite(rz)) { // the residual is zero, or no number
    solver[SOLVER_LINEAR] = 0;
    solver[SOLVER_STOP] = 1;
    solver[SOLVER_REASON] = 4;
    return;
  }
  solver[SOLVER_KEEP_Z] = k.first_length;
  solver[SOLVER_SLOPE] = k.first_length * rz;
  solver[SOLVER_LENGTH] = 1;
  if (k.remembers) {
    for (uint p = 0; p < k.partial_count; ++p)
      for (uint d = 0; d < HISTORY_DOTS; ++d)
        total[d] += k.history_partial[std::size_t{HISTORY_DOTS} * p + d];
    const uint newest = (static_cast<uint>(solver[SOLVER_NEWEST]) + 1) % memory;
    uint count = static_cast<uint>(solver[SOLVER_HISTORY]);
    for (uint i = 0; i < memory; ++i) {
      k.gram[5 * i + newest] = total[5 * i + 2];
      k.gram[5 * newest + i] = total[5 * i + 3];
      k.gram[25 + 5 * i + newest] = total[5 * i + 4];
      k.gram[25 + 5 * newest + i] = total[5 * i + 4];
    }
    real sy = k.gram[6 * newest], yz = k.gram[25 + 6 * newest];
    const bool good = k.forget == 0 && solver[SOLVER_CAUTIOUS] == 0 && sy > 0 && yz > 0 &&
                      __builtin_isfinite(sy) && __builtin_isfinite(yz);
    if (k.forget != 0 || solver[SOLVER_CAUTIOUS] > 0) count = 0;
    if (good) {
      solver[SOLVER_NEWEST] = static_cast<real>(newest);
      count = smaller(count + 1, memory);
    } else {
      count = smaller(count, memory - 1); // the slot was the oldest one's
    }
    const uint last = static_cast<uint>(solver[SOLVER_NEWEST]);
    if (count > 0) {
      real gamma = larger(real(0.02), smaller(k.largest_scale, k.gram[6 * last] / k.gram[25 + 6 * last]));
      real alpha[MEMORY] = {}, on_step[MEMORY] = {};
      for (uint a = 0; a < count; ++a) { // newest first
        uint i = (last + memory - a) % memory;
        real value = total[5 * i];
        for (uint b = 0; b < a; ++b) {
          uint j = (last + memory - b) % memory;
          value -= alpha[j] * k.gram[5 * i + j];
        }
        alpha[i] = value / k.gram[6 * i];
      }
      for (uint back = 0; back < count; ++back) { // oldest first
        uint a = count - 1 - back, i = (last + memory - a) % memory;
        real value = total[5 * i + 1];
        for (uint b = 0; b < count; ++b) {
          uint j = (last + memory - b) % memory;
          value -= alpha[j] * k.gram[25 + 5 * i + j];
        }
        value *= gamma;
        for (uint b = a + 1; b < count; ++b) {
          uint j = (last + memory - b) % memory;
          value += on_step[j] * k.gram[5 * j + i];
        }
        on_step[i] = alpha[i] - value / k.gram[6 * i];
      }
      real slope = gamma * rz;
      for (uint a = 0; a < count; ++a) {
        uint i = (last + memory - a) % memory;
        slope += on_step[i] * total[5 * i] - gamma * alpha[i] * total[5 * i + 1];
        solver[SOLVER_KEEP_STEP + i] = on_step[i];
        solver[SOLVER_KEEP_IMAGE + i] = -gamma * alpha[i];
      }
      if (slope > 0 && __builtin_isfinite(slope)) {
        solver[SOLVER_KEEP_Z] = gamma;
        solver[SOLVER_SLOPE] = slope;
        solver[SOLVER_LENGTH] = 1;
      } else {
        count = 0;
      }
    }
    if (count == 0)
      for (uint i = 0; i < memory; ++i) solver[SOLVER_KEEP_STEP + i] = solver[SOLVER_KEEP_IMAGE + i] = 0;
    solver[SOLVER_HISTORY] = static_cast<real>(count);
  }
  solver[SOLVER_LINEAR] = 0;
  if (k.energy_tolerance > 0 && solver[SOLVER_FALL] > 0) {
    const real forgotten =
        smaller(real(1), larger(real(0.25), 16 / larger(solver[SOLVER_COUNT] - 1, real(1))));
    const real left = larger(real(2.5) * larger(solver[SOLVER_SLOPE] / 2, solver[SOLVER_LEFT]),
                             (1 - forgotten) * solver[SOLVER_EXPECTED]);
    solver[SOLVER_EXPECTED] = left;
    solver[SOLVER_ENERGY_ERROR] = left / (solver[SOLVER_FALL] + left);
    if (solver[SOLVER_ENERGY_ERROR] <= k.energy_tolerance) {
      solver[SOLVER_STOP] = 1;
      solver[SOLVER_REASON] = 1;
      return;
    }
  }
  solver[SOLVER_ACTION] = 1;
  solver[SOLVER_STOP] = 0;
}

PLIANT_BODY(history_control)

} // namespace pliant::openmp::PLIANT_ISA
