// Forces of bonds between fluids; see kernels/fluid_bond_force.decl.
#include "kernels/fluid_bond_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/fluid_bonds.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <bool repeats, class real>
PLIANT_INLINE void forces(const kernels::fluid_bond_force::View<real>& k) {
  const Wide<real> none{}, one = none + 1, shortest_bond = spread(real(SHORTEST_BOND));
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> own = gather(k.fluid_start, part.index), u = gather(k.fluid_displacement, part.index);
    const Wide4<real> stay = gather(k.fluid_stay, part.index);
    Wide4<real> f{};
    if (bits<real>(stay.z > 0))
      for_each_entry(k, k.near_rest, part, [&](std::size_t entry) {
        const uint* const others = k.near + entry;
        const Wide<real> rest = load_wide(k.near_rest + entry);
        const WideMask<real> bonded = rest > 0;
        const Wide4<real> moved = gather_near(k.fluid_displacement, others),
                          their = gather_near(k.fluid_stay, others);
        const Wide3<real> from = to_others<repeats>(k, own, gather_near(k.fluid_start, others));
        const Wide3<real> y{from.x + (moved.x - u.x), from.y + (moved.y - u.y), from.z + (moved.z - u.z)};
        const Wide<real> length = root_wide<real>(dot(y, y)), x = bonded ? rest : one,
                         size = length > shortest_bond ? length : shortest_bond;
        const Wide<real> both = 1 / (x * size), per_rest = both * size; // one division for both
        const Wide<real> weight = bond_weights(k, dot(from, from)),
                         share = (bonded ? weight : none) * per_rest;
        const Wide<real> strain = (length - rest) * per_rest;
        const Wide<real> stress =
            stay.z * (stay.x * strain + stay.y) + their.z * (their.x * strain + their.y);
        const Wide<real> pull = share * stress * (both * x);
        f.x += pull * y.x, f.y += pull * y.y, f.z += pull * y.z;
        f.w += share * per_rest * (stay.z + their.z);
      });
    f.w = (stay.x == 0) & (stay.z == 0) ? none - 1 : f.w * k.bound;
    store(k.fluid_force + first, part.count, f);
  }
}

} // namespace

template <class real> void fluid_bond_force(const kernels::fluid_bond_force::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
  with_images(k, [&](auto repeats) { forces<repeats.value>(k); });
}

PLIANT_BODY(fluid_bond_force)

} // namespace pliant::openmp::PLIANT_ISA
