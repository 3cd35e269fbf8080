// See kernels/coarse_rotation.decl.
#include "kernels/coarse_rotation.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void coarse_rotation(const kernels::coarse_rotation::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
  const Real4<real>* const of = k.particles ? k.rotation : k.cell_rotation;
#pragma omp parallel for schedule(static) if (k.threads > 64)
  for (uint c = k.first_cell; c < k.first_cell + k.threads; ++c) {
    const uint begin = k.child_begin[c];
    const Quad<real> lead = load_quad(of[k.child[begin]]);
    Quad<real> sum = lead;
    for (uint at = begin + 1; at < k.child_begin[c + 1]; ++at) {
      const Quad<real> q = load_quad(of[k.child[at]]), p = q * lead;
      sum += p[0] + p[1] + p[2] + p[3] < 0 ? -q : q;
    }
    store_quad(k.cell_rotation[c], sum);
  }
}

PLIANT_BODY(coarse_rotation)

} // namespace pliant::openmp::PLIANT_ISA
