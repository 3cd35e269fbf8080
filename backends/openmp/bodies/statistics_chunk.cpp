// Sums of one chunk; see kernels/statistics_chunk.decl.
#include "kernels/statistics_chunk.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void statistics_chunk(const kernels::statistics_chunk::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint group = 0; group < k.threads / kernels::statistics_chunk::group_size; ++group) {
    real kinetic = 0, elastic = 0, speed2 = 0, shift2 = 0, wrong = 0;
    Vec3<real> momentum{0, 0, 0};
    for (uint i = k.chunk[group].x; i < k.chunk[group].y; ++i) {
      const real m = k.position[i].w;
      const Vec3<real> v = xyz(k.velocity[i]), u = xyz(k.displacement[i]), y = xyz(k.position[i]);
      const real v2 = dot(v, v), u2 = dot(u, u), stored = k.energies ? k.energy[i] : real(0);
      const bool finite = __builtin_isfinite(v2 + stored + y.x + y.y + y.z + u2);
      kinetic += m * v2 / 2;
      elastic += stored;
      momentum = momentum + m * v;
      if (!finite) wrong += 1;
      if (finite) speed2 = larger(speed2, v2), shift2 = larger(shift2, u2);
    }
    k.chunk_sum[2 * group] = {kinetic, elastic, speed2, wrong};
    k.chunk_sum[2 * group + 1] = {momentum.x, momentum.y, momentum.z, shift2};
  }
}

PLIANT_BODY(statistics_chunk)

} // namespace pliant::openmp::PLIANT_ISA
