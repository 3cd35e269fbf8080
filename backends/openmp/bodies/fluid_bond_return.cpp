// The end of a step of bonded fluids; see kernels/fluid_bond_return.decl.
#include "kernels/fluid_bond_return.h"
#include "backends/openmp/body.h"
#include "backends/openmp/fluid_bonds.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <bool repeats, class real>
PLIANT_INLINE void returns(const kernels::fluid_bond_return::View<real>& k) {
  const Wide<real> none{}, one = none + 1;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> start = gather(k.fluid_start, part.index), end = gather(k.fluid_place, part.index);
    StrainSums<real> sums;
    for_each_entry(k, k.near_rest, part, [&](std::size_t entry) {
      const Wide<real> rest = load_wide(k.near_rest + entry);
      const WideMask<real> bonded = rest > 0;
      const Wide3<real> from = to_others<repeats>(k, start, gather_near(k.fluid_start, k.near + entry));
      const Wide3<real> y = to_others<repeats>(k, end, gather_near(k.fluid_place, k.near + entry));
      const Wide<real> x = bonded ? rest : one, weight = bond_weights(k, dot(from, from));
      add_strain(sums, bonded ? weight : none, Wide<real>((root_wide<real>(dot(y, y)) - x) / x));
    });
    for (uint lane = 0; lane < part.count; ++lane) {
      const std::size_t i = std::size_t{first} + lane;
      const auto stay = k.fluid_stay[i];
      real stored = 0;
      if (stay.z > 0) {
        const real weight = sums.weight[lane], per = weight > 0 ? 1 / weight : 0;
        const real isotropic = per * sums.strain[lane];
        const real square = larger(per * sums.square[lane] - isotropic * isotropic, real(0));
        const auto* const rows = k.fluid_elastic + ELASTIC_ROWS * static_cast<uint>(static_cast<int>(stay.w));
        const auto bonds = rows[ELASTIC_BONDS];
        const real deviatoric = stay.z * weight * square,
                   volumetric = stay.z * weight * bonds.y * isotropic * isotropic;
        Stays<real> stays;
        if (k.plastic) {
          auto& so_far = k.fluid_flow[2 * i];
          stays = what_stays(rows[ELASTIC_YIELD], bonds.z, isotropic, square, so_far.x, k.equivalent);
          stays.isotropic *= stays.deviatoric;
          so_far.x += stays.strain;
          // The stress that stays times the strain that flows.
          so_far.y += deviatoric * stays.deviatoric * (1 - stays.deviatoric) +
                      volumetric * stays.isotropic * (1 - stays.isotropic);
          so_far.z += bonds.w * k.dimension * (1 - stays.isotropic) * isotropic;
          so_far.w = stays.yields ? 1 : 0;
          k.fluid_flow[2 * i + 1] = {isotropic, stays.isotropic, stays.deviatoric,
                                     k.equivalent * (1 - stays.deviatoric) * root(square)};
        }
        stored = (deviatoric * stays.deviatoric * stays.deviatoric +
                  volumetric * stays.isotropic * stays.isotropic) /
                 2;
      }
      if (k.measured) k.fluid_energy[i] = stored;
    }
  }
}

} // namespace

template <class real> void fluid_bond_return(const kernels::fluid_bond_return::View<real>& k) {
  with_images(k, [&](auto repeats) { returns<repeats.value>(k); });
}

PLIANT_BODY(fluid_bond_return)

} // namespace pliant::openmp::PLIANT_ISA
