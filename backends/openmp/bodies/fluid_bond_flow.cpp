// Rest lengths at the end of a step; see kernels/fluid_bond_flow.decl.
#include "kernels/fluid_bond_flow.h"
#include "backends/openmp/body.h"
#include "backends/openmp/fluid_bonds.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// Which of the others that do not move are ghosts.
template <class View, class Mask> PLIANT_INLINE Mask ghosts(const View& k, const uint* others, Mask still) {
  if (!bits<typename View::real>(still)) return still;
  for (uint lane = 0; lane < lanes<typename View::real>; ++lane)
    if (still[lane] && k.fluid_was[others[lane]].y != FAMILY_GHOST) still[lane] = 0;
  return still;
}

// Both particles of a bond compute its length: no rounding may depend on whose list it is.
template <bool repeats, class real> PLIANT_INLINE void flow(const kernels::fluid_bond_flow::View<real>& k) {
  const Wide<real> one = Wide<real>{} + 1, least = spread(k.least_rest), largest = spread(k.largest_rest);
  const Wide<real> least_stretch = spread(real(0.05));
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> before = gather(k.fluid_before, part.index);
    Wide4<real> own{}, now{};
    if (k.plastic) own = gather<2>(k.fluid_flow + 1, part.index);
    if (k.spread) now = gather(k.fluid_place, part.index);
    for_each_entry(k, k.near_rest, part, [&](std::size_t entry) {
      const uint* const others = k.near + entry;
      const Wide<real> old = load_wide(k.near_rest + entry);
      const WideMask<real> bonded = old > 0;
      if (!bits<real>(bonded)) return;
      const Wide4<real> there = gather_near(k.fluid_before, others);
      const Wide3<real> y = to_others<repeats>(k, before, there);
      const Wide<real> size = root_wide<real>(dot(y, y));
      Wide<real> rest = bonded ? old : one;
      if (k.plastic) {
        const Wide4<real> theirs = gather<2>(k.fluid_flow + 1, others);
        const WideMask<real> ghost = ghosts(k, others, there.w < 0);
        const Wide4<real> other{
            ghost ? own.x : theirs.x, ghost ? own.y : theirs.y, ghost ? own.z : theirs.z, {}};
        const WideMask<real> flows = (own.y < 1) | (own.z < 1) | (other.y < 1) | (other.z < 1);
        const Wide<real> strain = (size - rest) / rest;
        const Wide<real> by_own = own.y * own.x + own.z * (strain - own.x);
        const Wide<real> by_other = other.y * other.x + other.z * (strain - other.x);
        const Wide<real> stretch = 1 + (by_own + by_other) / 2;
        const Wide<real> flowed = size / (stretch > least_stretch ? stretch : least_stretch);
        rest = flows ? flowed : rest;
      }
      if (k.spread) {
        const Wide3<real> y_now = to_others<repeats>(k, now, gather_near(k.fluid_place, others));
        const Wide<real> size_now = root_wide<real>(dot(y_now, y_now));
        const Wide<real> followed = rest * (size_now / (size > least ? size : one));
        rest = (size > least) & (size_now != size) ? followed : rest;
      }
      rest = rest > least ? rest : least;
      rest = rest < largest ? rest : largest;
      rest = bonded ? rest : old;
      // Lanes beyond the last particle of the part are the next part's.
      store_reals(k.near_rest + entry, part.count, rest);
    });
  }
}

} // namespace

template <class real> void fluid_bond_flow(const kernels::fluid_bond_flow::View<real>& k) {
  with_images(k, [&](auto repeats) { flow<repeats.value>(k); });
}

PLIANT_BODY(fluid_bond_flow)

} // namespace pliant::openmp::PLIANT_ISA
