// Multipliers of the density constraints; see kernels/fluid_lambda.decl.
#include "kernels/fluid_lambda.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "backends/openmp/smoothing.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_lambda(const kernels::fluid_lambda::View<real>& k) {
  const Wide<real> none{};
  const real per_support = 1 / k.support;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> place = gather(k.fluid_place, part.index);
    Wide<real> sum = magnitudes<real>(place.w) * spline_value(none), squares{};
    Wide3<real> gradient{};
    for_each_near(k, part, place, [&](const uint*, const Wide4<real>& d, WideMask<real> self) {
      const Wide<real> q = root_wide<real>(d.x * d.x + d.y * d.y + d.z * d.z) * per_support;
      const Wide<real> mass = magnitudes<real>(d.w), slope = spline_slope(q);
      const Wide<real> value = mass * spline_value(q);
      sum += self ? none : value;
      const Wide3<real> steep{slope * d.x, slope * d.y, slope * d.z};
      gradient.x += mass * steep.x, gradient.y += mass * steep.y, gradient.z += mass * steep.z;
      squares += (d.w > 0 ? d.w : none) * dot(steep, steep);
    });
    Wide<real> rest, softness, most, edge;
    for (uint lane = 0; lane < lanes<real>; ++lane) {
      const auto* rows =
          k.fluid_material +
          FLUID_ROWS * static_cast<uint>(static_cast<int>(k.fluid_velocity[part.index[lane]].w));
      rest[lane] = rows[FLUID_TRAITS].x;
      softness[lane] = rows[FLUID_LIMITS].x, most[lane] = rows[FLUID_LIMITS].y;
      edge[lane] = rows[FLUID_LIMITS].z;
    }
    Wide<real> error = k.value_scale * sum / rest - 1;
    if (k.walls) {
      const Wide4<real> wall = gather(k.fluid_wall, part.index);
      const Wide<real> scale = rest / k.slope_scale;
      error += wall.w;
      gradient.x += scale * wall.x, gradient.y += scale * wall.y, gradient.z += scale * wall.z;
    }
    if (k.measured) {
      const Wide<real> steep2 = k.slope_scale * k.slope_scale * dot(gradient, gradient), one = none + 1;
      store(k.fluid_measure + first, part.count,
            Wide4<real>{place.w > 0 ? error : none, place.w > 0 ? steep2 : none,
                        place.w > 0 ? (steep2 <= edge * edge ? one : none) : none, place.w > 0 ? one : none});
      continue;
    }
    const Wide<real> scale = k.slope_scale / rest, total = load_wide(k.fluid_total + first);
    const Wide<real> stiffness = scale * scale * (dot(gradient, gradient) / place.w + squares) + softness;
    Wide<real> change = -k.relaxation * (error < most ? error : most) / (stiffness * rest);
    change = change < -total ? change : -total;
    change = place.w > 0 ? change : none;
    store_reals(k.fluid_total + first, part.count, Wide<real>(total + change));
    store_reals(k.fluid_lambda + first, part.count, change);
  }
}

PLIANT_BODY(fluid_lambda)

} // namespace pliant::openmp::PLIANT_ISA
