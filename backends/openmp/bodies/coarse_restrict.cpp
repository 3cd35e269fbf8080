// See kernels/coarse_restrict.decl.
#include "kernels/coarse_restrict.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void coarse_restrict(const kernels::coarse_restrict::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static) if (k.threads > 256)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const uint slice = k.first_slice + first / 16, lane = first % 16, n = k.first_node + first;
    Wide3<real> b{};
    for (std::size_t row = k.gather_begin[slice]; row < k.gather_begin[slice + 1]; ++row) {
      const Wide<real> w = load_wide(k.gather_weight + 16 * row + lane);
      const Wide4<real> r = gather(k.source, k.gather + 16 * row + lane);
      b.x += w * r.x, b.y += w * r.y, b.z += w * r.z;
    }
    const real* const inverse = k.inverse_block + std::size_t{n / 16} * 144 + lane;
    const auto row = [&](uint at) {
      return k.relaxation * (load_wide(inverse + 48 * at) * b.x + load_wide(inverse + 48 * at + 16) * b.y +
                             load_wide(inverse + 48 * at + 32) * b.z);
    };
    const uint count = smaller(k.threads - first, lanes<real>);
    store(k.coarse_load + n, count, Wide4<real>{b.x, b.y, b.z, Wide<real>{}});
    store(k.coarse_iterate + n, count, Wide4<real>{row(0), row(1), row(2), Wide<real>{}});
  }
}

PLIANT_BODY(coarse_restrict)

} // namespace pliant::openmp::PLIANT_ISA
