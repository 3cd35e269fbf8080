// Shifts that multipliers make; see kernels/fluid_shift.decl.
#include "kernels/fluid_shift.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "backends/openmp/smoothing.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_shift(const kernels::fluid_shift::View<real>& k) {
  const Wide<real> none{};
  const real per_support = 1 / k.support;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> place = gather(k.fluid_lambda, part.index);
    Wide3<real> theirs{};
    for_each_near(k, k.fluid_lambda, part, place, [&](const uint*, const Wide4<real>& d, WideMask<real>) {
      const Wide<real> q = root_wide<real>(d.x * d.x + d.y * d.y + d.z * d.z) * per_support, per_q = 1 / q;
      const Wide<real> push = d.w * spline_slope(q, per_q);
      theirs.x += push * d.x, theirs.y += push * d.y, theirs.z += push * d.z;
    });
    const Wide4<real> pull = gather(k.fluid_pull, part.index), start = gather(k.fluid_start, part.index);
    Wide4<real> moved = gather(k.fluid_moved, part.index);
    const WideMask<real> moves = pull.w > 0;
    moved.x += moves ? pull.x + k.slope_scale * theirs.x : none;
    moved.y += moves ? pull.y + k.slope_scale * theirs.y : none;
    moved.z += moves ? pull.z + k.slope_scale * theirs.z : none;
    store(k.fluid_moved + first, part.count, moved);
    store(k.fluid_place + first, part.count,
          Wide4<real>{moves ? start.x + moved.x : place.x, moves ? start.y + moved.y : place.y,
                      moves ? start.z + moved.z : place.z, pull.w});
  }
}

PLIANT_BODY(fluid_shift)

} // namespace pliant::openmp::PLIANT_ISA
