// Shifts that multipliers make; see kernels/fluid_shift.decl.
#include "kernels/fluid_shift.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "backends/openmp/smoothing.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_shift(const kernels::fluid_shift::View<real>& k) {
  const Wide<real> none{};
  const real per_support = 1 / k.support;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> place = gather(k.fluid_place, part.index);
    Wide3<real> own{}, theirs{};
    for_each_near(k, part, place, [&](const uint* neighbours, const Wide4<real>& d, WideMask<real>) {
      const Wide<real> q = root_wide<real>(d.x * d.x + d.y * d.y + d.z * d.z) * per_support;
      Wide<real> lambda;
      for (uint lane = 0; lane < lanes<real>; ++lane) lambda[lane] = k.fluid_lambda[neighbours[lane]];
      const Wide<real> slope = spline_slope(q), mass = magnitudes<real>(d.w);
      const Wide3<real> steep{slope * d.x, slope * d.y, slope * d.z};
      own.x += mass * steep.x, own.y += mass * steep.y, own.z += mass * steep.z;
      theirs.x += lambda * steep.x, theirs.y += lambda * steep.y, theirs.z += lambda * steep.z;
    });
    if (k.walls) {
      const Wide4<real> wall = gather(k.fluid_wall, part.index);
      Wide<real> scale;
      for (uint lane = 0; lane < lanes<real>; ++lane) {
        const int fluid = static_cast<int>(k.fluid_velocity[part.index[lane]].w);
        scale[lane] = k.fluid_material[FLUID_ROWS * fluid + FLUID_TRAITS].x / k.slope_scale;
      }
      own.x += scale * wall.x, own.y += scale * wall.y, own.z += scale * wall.z;
    }
    const Wide<real> each = load_wide(k.fluid_lambda + first) / place.w;
    const auto moved = [&](Wide<real> from, Wide<real> by_own, Wide<real> by_theirs) -> Wide<real> {
      return from + (place.w > 0 ? k.slope_scale * (each * by_own + by_theirs) : none);
    };
    store(k.fluid_shift + first, part.count,
          Wide4<real>{moved(place.x, own.x, theirs.x), moved(place.y, own.y, theirs.y),
                      moved(place.z, own.z, theirs.z), place.w});
  }
}

PLIANT_BODY(fluid_shift)

} // namespace pliant::openmp::PLIANT_ISA
