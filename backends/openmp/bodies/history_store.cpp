// See kernels/history_store.decl.
#include "kernels/history_store.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void history_store(const kernels::history_store::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0) return;
  const uint slot = (static_cast<uint>(k.solver[SOLVER_NEWEST]) + 1) % MEMORY;
  Real4<real>* const step = k.history + std::size_t{HISTORY_STEP + slot} * k.stride;
  Real4<real>* const change = k.history + std::size_t{HISTORY_CHANGE + slot} * k.stride;
  Real4<real>* const last = k.history + std::size_t{HISTORY_RESIDUAL} * k.stride;
  const Quad<real> no_w{1, 1, 1, 0};
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const Quad<real> r = load_quad(k.residual[i]) * no_w;
    store_quad(step[i], (load_quad(k.displacement[i]) - load_quad(k.best_iterate[i])) * no_w);
    store_quad(change[i], load_quad(last[i]) - r);
    store_quad(last[i], r);
  }
}

PLIANT_BODY(history_store)

} // namespace pliant::openmp::PLIANT_ISA
