// See kernels/history_dots.decl.
#include "kernels/history_dots.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void history_dots(const kernels::history_dots::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  const uint newest = (static_cast<uint>(k.solver[SOLVER_NEWEST]) + 1) % MEMORY;
  constexpr uint group = kernels::history_dots::group_size;
  const auto row = [&](uint at) { return k.history + std::size_t{at} * k.stride; };
  Real4<real>* const last = row(HISTORY_PRECONDITIONED);
  Real4<real>* const new_image = row(HISTORY_IMAGE + newest);
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < (k.threads + group - 1) / group; ++block) {
    const uint begin = group * block, end = smaller(group * (block + 1), k.threads);
    for (uint i = begin; i < end; ++i) {
      const Quad<real> z = load_quad(k.preconditioned[i]);
      store_quad(new_image[i], load_quad(last[i]) - z);
      store_quad(last[i], z);
    }
    const Real4<real>*const step_new = row(HISTORY_STEP + newest), *const change_new =
                                                                       row(HISTORY_CHANGE + newest);
    for (uint slot = 0; slot < MEMORY; ++slot) {
      const Real4<real>*const s = row(HISTORY_STEP + slot), *const y = row(HISTORY_CHANGE + slot);
      const Real4<real>* const z = row(HISTORY_IMAGE + slot);
      Quad<real> sr{}, zr{}, sy_new{}, s_new_y{}, yz_new{};
      for (uint i = begin; i < end; ++i) {
        const Quad<real> r = load_quad(k.residual[i]), step = load_quad(s[i]), change = load_quad(y[i]);
        sr += step * r, zr += load_quad(z[i]) * r;
        sy_new += step * load_quad(change_new[i]);
        s_new_y += load_quad(step_new[i]) * change;
        yz_new += change * load_quad(new_image[i]);
      }
      real* const out = k.history_partial + std::size_t{HISTORY_DOTS} * block + 5 * slot;
      const auto sum = [](Quad<real> v) { return v[0] + v[1] + v[2]; };
      out[0] = sum(sr), out[1] = sum(zr), out[2] = sum(sy_new), out[3] = sum(s_new_y), out[4] = sum(yz_new);
    }
  }
}

PLIANT_BODY(history_dots)

} // namespace pliant::openmp::PLIANT_ISA
