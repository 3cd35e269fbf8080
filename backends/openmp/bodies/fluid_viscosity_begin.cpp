// Rates and the first residual; see kernels/fluid_viscosity_begin.decl.
#include "kernels/fluid_viscosity_begin.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "backends/openmp/smoothing.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <bool central, class real>
PLIANT_INLINE void begin(const kernels::fluid_viscosity_begin::View<real>& k) {
  constexpr uint group = kernels::fluid_viscosity_begin::group_size;
  // Particles nearer to each other are held to be as far, whatever the direction.
  const real least_arm = real(1e-3) * k.support, least_square = least_arm * least_arm;
  const Wide<real> none{};
  const real per_support = 1 / k.support;
  const auto viscosity_of = [&](Wide<real> material, WideMask<real> is_fluid) {
    Wide<real> mu;
    for (uint lane = 0; lane < lanes<real>; ++lane)
      mu[lane] = is_fluid[lane]
                     ? k.fluid_material[FLUID_ROWS * static_cast<uint>(static_cast<int>(material[lane])) +
                                        FLUID_TRAITS]
                           .y
                     : real(0);
    return mu;
  };
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < (k.threads + group - 1) / group; ++block) {
    real energy = 0;
    for (uint first = group * block; first < smaller(group * (block + 1), k.threads); first += lanes<real>) {
      const Part<real> part = make_part<real>(first, k.threads - first);
      const Wide4<real> place = gather(k.fluid_place, part.index), v = gather(k.fluid_velocity, part.index);
      const Wide4<real> start = central ? gather(k.fluid_start, part.index) : Wide4<real>{};
      const Wide<real> mu = viscosity_of(v.w, place.w > 0);
      const Wide<real> per_mass = k.coupling / (place.w > 0 ? place.w : none + 1);
      real* const first_rate = k.near_rate + (std::size_t{16} * k.rows * (first / 16) + first % 16);
      Wide3<real> away{}, change{}; // away: from the walls
      const auto sweep = [&](auto with_walls) {
        constexpr bool walls = decltype(with_walls)::value;
        real* rates = first_rate;
        WideMask<real> ghosts{};
        change = Wide3<real>{};
        for_each_near(k, part, place, [&](const uint* neighbours, const Wide4<real>& d, WideMask<real> self) {
          const Wide4<real> w = gather_near(k.fluid_velocity, neighbours);
          Wide<real> both = mu;
          if (k.mixed) {
            const Wide<real> ghost_mu = d.w < 0 ? mu : none, theirs = ghost_mu + viscosity_of(w.w, d.w > 0);
            const Wide<real> sum = mu + theirs;
            both = 2 * mu * theirs / (sum > 0 ? sum : none + 1);
          }
          const Wide<real> share =
              viscous_laplacian<Wide<real>>(root_wide<real>(d.x * d.x + d.y * d.y + d.z * d.z) * per_support);
          Wide<real> rate = per_mass * both * share;
          rate = self ? none : rate;
          if constexpr (walls) {
            const Wide<real> depth = w.w < 0 ? -w.w : none;
            Wide<real> reach = d.x * away.x + d.y * away.y + d.z * away.z - depth;
            reach = reach > k.least_distance ? reach : spread(k.least_distance);
            const Wide<real> further = rate * ((reach + depth) / reach);
            rate = d.w < 0 ? further : rate;
          } else {
            ghosts |= d.w < 0;
          }
          rate = place.w > 0 ? rate : none;
          Wide3<real> faster{w.x - v.x, w.y - v.y, w.z - v.z};
          if constexpr (central) {
            const Wide3<real> arm = from_near(k, k.fluid_start, start, neighbours);
            const Wide<real> square = dot(arm, arm), along = dot(arm, faster);
            rate /= square > least_square ? square : spread(least_square);
            faster = {along * arm.x, along * arm.y, along * arm.z};
          }
          store_reals(rates, lanes<real>, rate);
          rates += 16;
          change.x += rate * faster.x, change.y += rate * faster.y, change.z += rate * faster.z;
        });
        return bits<real>(ghosts) != 0;
      };
      if (sweep(std::false_type()) && k.ghosts) { // few are near a wall
        for_each_near(k, part, place, [&](const uint*, const Wide4<real>& d, WideMask<real>) {
          if (!bits<real>(d.w < 0)) return;
          const Wide<real> share =
              viscous_laplacian<Wide<real>>(root_wide<real>(d.x * d.x + d.y * d.y + d.z * d.z) * per_support);
          const Wide<real> weight = d.w < 0 ? share : none;
          away.x += weight * d.x, away.y += weight * d.y, away.z += weight * d.z;
        });
        const Wide<real> far = root_wide<real>(dot(away, away)), per_far = 1 / (far > 0 ? far : none + 1);
        away.x *= per_far, away.y *= per_far, away.z *= per_far;
        sweep(std::true_type());
      }
      const Wide<real> mass = place.w > 0 ? place.w : none;
      store(k.fluid_residual + first, part.count, Wide4<real>{change.x, change.y, change.z, mass});
      const Wide<real> each = mass * (v.x * v.x + v.y * v.y + v.z * v.z);
      for (uint lane = 0; lane < part.count; ++lane) energy += each[lane];
    }
    k.fluid_partial[block] = {energy, 0, 0, 0};
  }
}

} // namespace

template <class real> void fluid_viscosity_begin(const kernels::fluid_viscosity_begin::View<real>& k) {
  if (k.central)
    begin<true>(k);
  else
    begin<false>(k);
}

PLIANT_BODY(fluid_viscosity_begin)

} // namespace pliant::openmp::PLIANT_ISA
