// Law M2 with what flows; see kernels/fluid_bond_state.decl.
#include "kernels/fluid_bond_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/fluid_bonds.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <bool repeats, class real>
PLIANT_INLINE void states(const kernels::fluid_bond_state::View<real>& k) {
  const Wide<real> none{}, one = none + 1;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> own = gather(k.fluid_start, part.index), u = gather(k.fluid_displacement, part.index);
    StrainSums<real> sums;
    for_each_entry(k, k.near_rest, part, [&](std::size_t entry) {
      const Wide<real> rest = load_wide(k.near_rest + entry);
      const WideMask<real> bonded = rest > 0;
      const Wide4<real> moved = gather_near(k.fluid_displacement, k.near + entry);
      const Wide3<real> from = to_others<repeats>(k, own, gather_near(k.fluid_start, k.near + entry));
      const Wide3<real> y{from.x + (moved.x - u.x), from.y + (moved.y - u.y), from.z + (moved.z - u.z)};
      const Wide<real> x = bonded ? rest : one, weight = bond_weights(k, dot(from, from));
      add_strain(sums, bonded ? weight : none, Wide<real>((root_wide<real>(dot(y, y)) - x) / x));
    });
    for (uint lane = 0; lane < part.count; ++lane) {
      auto& stay = k.fluid_stay[first + lane];
      if (!(stay.z > 0)) continue;
      const real per = sums.weight[lane] > 0 ? 1 / sums.weight[lane] : 0, isotropic = per * sums.strain[lane];
      const auto* const rows = k.fluid_elastic + ELASTIC_ROWS * static_cast<uint>(static_cast<int>(stay.w));
      Stays<real> stays;
      if (k.plastic) {
        const real square = larger(per * sums.square[lane] - isotropic * isotropic, real(0));
        stays = what_stays(rows[ELASTIC_YIELD], rows[ELASTIC_BONDS].z, isotropic, square,
                           k.fluid_flow[2 * (std::size_t{first} + lane)].x, k.equivalent);
      }
      stay.z = rows[ELASTIC_BONDS].x / larger(sums.weight[lane], real(FULL_BONDS));
      stay.x = stays.deviatoric;
      stay.y = (rows[ELASTIC_BONDS].y * stays.isotropic - stays.deviatoric) * isotropic;
    }
  }
}

} // namespace

template <class real> void fluid_bond_state(const kernels::fluid_bond_state::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
  with_images(k, [&](auto repeats) { states<repeats.value>(k); });
}

PLIANT_BODY(fluid_bond_state)

} // namespace pliant::openmp::PLIANT_ISA
