// Forces of bonds between fluids; see kernels/fluid_bond_force.decl.
#include "kernels/fluid_bond_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/fluid_bonds.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_bond_force(const kernels::fluid_bond_force::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
  const Wide<real> none{}, one = none + 1, shortest_bond = spread(real(SHORTEST_BOND));
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> own = gather(k.fluid_start, part.index), u = gather(k.fluid_displacement, part.index);
    const Wide4<real> stay = gather(k.fluid_stay, part.index);
    Wide4<real> f{};
    if (bits<real>(stay.z > 0))
      for (uint r = 0; r < k.near_count[first / 16]; ++r) {
        const std::size_t entry = list_entry(k, part, r);
        const uint* const others = k.near + entry;
        const Wide<real> rest = load_wide(k.near_rest + entry);
        const WideMask<real> bonded = rest > 0;
        const Wide4<real> moved = gather(k.fluid_displacement, others), their = gather(k.fluid_stay, others);
        const Wide3<real> from = to_others(k, own, gather(k.fluid_start, others));
        const Wide3<real> y{from.x + (moved.x - u.x), from.y + (moved.y - u.y), from.z + (moved.z - u.z)};
        const Wide<real> per_rest = 1 / (bonded ? rest : one), size = root_wide<real>(dot(y, y));
        const Wide<real> weight = bond_weights(k, dot(from, from)),
                         share = (bonded ? weight : none) * per_rest;
        const Wide<real> strain = (size - rest) * per_rest;
        const Wide<real> stress =
            stay.z * (stay.x * strain + stay.y) + their.z * (their.x * strain + their.y);
        const Wide<real> pull = share * stress / (size > shortest_bond ? size : shortest_bond);
        f.x += pull * y.x, f.y += pull * y.y, f.z += pull * y.z;
        f.w += share * per_rest * (stay.z + their.z);
      }
    f.w *= k.bound;
    store(k.fluid_force + first, part.count, f);
  }
}

PLIANT_BODY(fluid_bond_force)

} // namespace pliant::openmp::PLIANT_ISA
