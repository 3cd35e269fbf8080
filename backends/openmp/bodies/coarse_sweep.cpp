// See kernels/coarse_sweep.decl.
#include "kernels/coarse_sweep.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void coarse_sweep(const kernels::coarse_sweep::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static) if (k.threads > 128)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const uint n = k.first_node + first, lane = n % 16;
    const Part<real> part = make_part<real>(n, k.threads - first);
    const Wide4<real> b = gather(k.coarse_load, part.index);
    Wide3<real> r{b.x, b.y, b.z};
    const uint* neighbour = k.neighbour + std::size_t{n / 16} * 27 * 16 + lane;
    const real* m = k.matrix + std::size_t{n / 16} * 27 * 144 + lane;
    for (uint slot = 0; slot < 27; ++slot, neighbour += 16, m += 144) {
      const Wide4<real> x = gather(k.coarse_iterate, neighbour);
      r.x -= load_wide(m) * x.x + load_wide(m + 16) * x.y + load_wide(m + 32) * x.z;
      r.y -= load_wide(m + 48) * x.x + load_wide(m + 64) * x.y + load_wide(m + 80) * x.z;
      r.z -= load_wide(m + 96) * x.x + load_wide(m + 112) * x.y + load_wide(m + 128) * x.z;
    }
    if (k.relaxed) {
      const real* const inverse = k.inverse_block + std::size_t{n / 16} * 144 + lane;
      const Wide4<real> x = gather(k.coarse_iterate, part.index);
      const auto row = [&](uint at) {
        return k.relaxation * (load_wide(inverse + 48 * at) * r.x + load_wide(inverse + 48 * at + 16) * r.y +
                               load_wide(inverse + 48 * at + 32) * r.z);
      };
      r = {x.x + row(0), x.y + row(1), x.z + row(2)};
    }
    store(k.coarse_result + n, part.count, Wide4<real>{r.x, r.y, r.z, Wide<real>{}});
  }
}

PLIANT_BODY(coarse_sweep)

} // namespace pliant::openmp::PLIANT_ISA
