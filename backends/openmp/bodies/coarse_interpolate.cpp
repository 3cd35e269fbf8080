// See kernels/coarse_interpolate.decl.
#include "kernels/coarse_interpolate.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void coarse_interpolate(const kernels::coarse_interpolate::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static) if (k.threads > 512)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const uint n = k.first_node + first;
    const Part<real> part = make_part<real>(n, k.threads - first);
    Wide4<real> x = gather(k.coarse_iterate, part.index);
    const std::size_t base = std::size_t{n / 16} * 128 + n % 16;
    for (std::size_t at = base; at < base + 128; at += 16) {
      const Wide<real> w = load_wide(k.parent_weight + at);
      const Wide4<real> parent = gather(k.coarse_result, k.node_parent + at);
      x.x += w * parent.x, x.y += w * parent.y, x.z += w * parent.z;
    }
    store(k.coarse_iterate + n, part.count, x);
  }
}

PLIANT_BODY(coarse_interpolate)

} // namespace pliant::openmp::PLIANT_ISA
