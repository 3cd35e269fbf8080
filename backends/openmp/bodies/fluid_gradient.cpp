// Gradients of the density and normals; see kernels/fluid_gradient.decl.
#include "kernels/fluid_gradient.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "backends/openmp/smoothing.h"
#include "shaders/common/fluid.glsl"
#include "shaders/common/spread.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <bool tension, class real>
PLIANT_INLINE void gradient(const kernels::fluid_gradient::View<real>& k) {
  const Wide<real> none{}, one = none + 1;
  const real per_support = 1 / k.support;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> place = gather(k.fluid_place, part.index);
    const WideMask<real> moves = place.w > 0;
    Wide3<real> g{}, normal{};
    Wide<real> cover{}, nearest = one;
    for_each_near(k, part, place, [&](const uint*, const Wide4<real>& d, WideMask<real> self) {
      const Wide<real> r2 = d.x * d.x + d.y * d.y + d.z * d.z, q = root_wide<real>(r2) * per_support;
      const Wide<real> per_q = 1 / (q + real(1e-18)); // where places coincide the differences vanish
      const Wide<real> steep = spiky_slope(q, per_q), slope = spline_slope(q, per_q);
      g.x += steep * d.x, g.y += steep * d.y, g.z += steep * d.z;
      normal.x += slope * d.x, normal.y += slope * d.y, normal.z += slope * d.z;
      cover -= slope * r2;
      if constexpr (tension) {
        const Wide<real> closer = q < nearest ? q : nearest;
        nearest = self ? nearest : closer;
      }
    });
    const Wide<real> g_scale = moves ? spread(k.spiky_scale) : none;
    g.x *= g_scale, g.y *= g_scale, g.z *= g_scale;
    Wide<real> share;
    for (uint lane = 0; lane < lanes<real>; ++lane) {
      const uint material =
          moves[lane] ? static_cast<uint>(static_cast<int>(k.fluid_velocity[part.index[lane]].w)) : 0;
      share[lane] = k.fluid_material[FLUID_ROWS * material + FLUID_TRAITS].z;
    }
    if (k.fickian) {
      const Wide<real> far = k.rate * root_wide<real>(dot(g, g)), most = k.limit / (far > 0 ? far : one);
      share = share * far > k.limit ? most : share;
    }
    const Wide<real> length = k.normal_scale * root_wide<real>(dot(normal, normal));
    const Wide<real> capped = k.normal_scale / (length > 1 ? length : one);
    const WideMask<real> surface = moves & (k.cover_scale * cover < real(SURFACE_COVER));
    const Wide<real> scale = surface ? capped : none, least = spread(real(1e-30));
    Wide<real> mark = surface ? -(share > least ? share : least) : share;
    mark = moves ? mark : one + 1;
    const Wide<real> distance = tension ? Wide<real>(nearest * k.support) : none;
    store(k.fluid_gradient + first, part.count, Wide4<real>{g.x, g.y, g.z, moves ? distance : none});
    store(k.fluid_normal + first, part.count,
          Wide4<real>{scale * normal.x, scale * normal.y, scale * normal.z, mark});
  }
}

} // namespace

template <class real> void fluid_gradient(const kernels::fluid_gradient::View<real>& k) {
  k.tension ? gradient<true>(k) : gradient<false>(k);
}

PLIANT_BODY(fluid_gradient)

} // namespace pliant::openmp::PLIANT_ISA
