// Multipliers of the density constraints; see kernels/fluid_lambda.decl.
#include "kernels/fluid_lambda.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "backends/openmp/smoothing.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// Sums over the neighbours, without the factors of value and slope.
template <class real> struct Sums {
  Wide<real> value{}, squares{};
  Wide3<real> gradient{};
};

template <bool warm, class real>
PLIANT_INLINE Sums<real> sum_up(const kernels::fluid_lambda::View<real>& k, const Part<real>& part,
                                const Wide4<real>& place) {
  const Wide<real> none{};
  const real per_support = 1 / k.support;
  Sums<real> sums;
  for_each_near(k, part, place, [&](const uint*, const Wide4<real>& d, WideMask<real> self) {
    const Wide<real> r2 = d.x * d.x + d.y * d.y + d.z * d.z;
    const Wide<real> q = root_wide<real>(r2) * per_support,
                     per_q = 1 / q; // without bound at 0, where slopes have one
    const Wide<real> mass = counting_mass<real>(d.w), slope = spline_slope(q, per_q), steep = mass * slope;
    sums.gradient.x += steep * d.x, sums.gradient.y += steep * d.y, sums.gradient.z += steep * d.z;
    if constexpr (!warm) {
      const Wide<real> value = mass * spline_value(q);
      sums.value += self ? none : value;
      sums.squares += most_of<Wide<real>>(d.w, none) * (slope * slope * r2);
    }
  });
  return sums;
}

/// Within 0 and 1.
template <class W> PLIANT_INLINE W share(W of) {
  const W none{}, one = none + 1;
  of = of > none ? of : none;
  return of < one ? of : one;
}

template <bool warm, class real> PLIANT_INLINE void sweep(const kernels::fluid_lambda::View<real>& k) {
  const Wide<real> none{};
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> place = gather(k.fluid_place, part.index);
    const WideMask<real> moves = place.w > 0;
    const Sums<real> sums = sum_up<warm>(k, part, place);
    Wide3<real> gradient = sums.gradient;
    Wide<real> rest, softness, most, edge, strength;
    for (uint lane = 0; lane < lanes<real>; ++lane) {
      const real material = larger(k.fluid_velocity[part.index[lane]].w, real(0)); // a ghost has none
      const auto* rows = k.fluid_material + FLUID_ROWS * static_cast<uint>(static_cast<int>(material));
      rest[lane] = rows[FLUID_TRAITS].x;
      softness[lane] = rows[FLUID_LIMITS].x, most[lane] = rows[FLUID_LIMITS].y;
      edge[lane] = rows[FLUID_LIMITS].z, strength[lane] = rows[FLUID_LIMITS].w;
    }
    const Wide<real> own = counting_mass<real>(place.w) * spline_value(none);
    Wide<real> error = k.value_scale * (own + sums.value) / rest - 1;
    if (k.walls) {
      const Wide4<real> wall = gather(k.fluid_wall, part.index);
      const Wide<real> scale = rest / k.slope_scale;
      error += wall.w;
      gradient.x += scale * wall.x, gradient.y += scale * wall.y, gradient.z += scale * wall.z;
    }
    if (k.measured) {
      const Wide<real> steep2 = k.slope_scale * k.slope_scale * dot(gradient, gradient), one = none + 1;
      store(k.fluid_measure + first, part.count,
            Wide4<real>{moves ? error : none, moves ? steep2 : none,
                        moves ? (steep2 <= edge * edge ? one : none) : none, moves ? one : none});
      continue;
    }
    const Wide<real> total = load_wide(k.fluid_total + first);
    Wide<real> change = total;
    if constexpr (!warm) {
      const Wide<real> scale = k.slope_scale / rest;
      const Wide<real> stiffness =
          scale * scale * (dot(gradient, gradient) / place.w + sums.squares) + softness;
      change = -k.relaxation * (error < most ? error : most) / (stiffness * rest);
      if (k.momentum > 0) { // not before: it may be anything
        Wide<real> last;
        for (uint lane = 0; lane < lanes<real>; ++lane) last[lane] = k.fluid_lambda[part.index[lane]].w;
        change += k.momentum * last;
      }
      Wide<real> left = -total;
      if (k.pulls) {
        const Wide<real> steepness = root_wide<real>(dot(gradient, gradient)) * k.slope_scale / edge;
        left += strength * (k.step2 * place.w) * share(4 - 4 * steepness) * share(4 * error + 2);
      }
      change = change < left ? change : left;
    }
    change = moves ? change : none;
    if constexpr (!warm) store_reals(k.fluid_total + first, part.count, Wide<real>(total + change));
    const Wide<real> each = k.slope_scale * change / place.w;
    const auto pull = [&](Wide<real> along) -> Wide<real> { return moves ? each * along : none; };
    store(k.fluid_lambda + first, part.count, Wide4<real>{place.x, place.y, place.z, change});
    store(k.fluid_pull + first, part.count,
          Wide4<real>{pull(gradient.x), pull(gradient.y), pull(gradient.z), place.w});
  }
}

} // namespace

template <class real> void fluid_lambda(const kernels::fluid_lambda::View<real>& k) {
  if (k.warm)
    sweep<true>(k);
  else
    sweep<false>(k);
}

PLIANT_BODY(fluid_lambda)

} // namespace pliant::openmp::PLIANT_ISA
