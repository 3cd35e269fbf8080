// Bonds of fluids: walks over them, wide, and what flows.
#pragma once

#include "backends/openmp/near.h"
#include "shaders/common/fluid_bond.glsl"

namespace pliant::openmp::PLIANT_ISA {

/// A list's entry r of the particles of a part: its first lane.
template <class View, class real>
PLIANT_INLINE std::size_t list_entry(const View& k, const Part<real>& part, uint r) {
  return std::size_t{16} * (std::size_t{k.rows} * (part.first / 16) + r) + part.first % 16;
}

/// Calls visit(entry) for the entries of a part's list; `along` goes with `near`, a value an entry.
template <class View, class real, class Visit>
PLIANT_INLINE void for_each_entry(const View& k, const real* along, const Part<real>& part, Visit visit) {
  const std::size_t slice = std::size_t{16} * k.rows;
  std::size_t entry = list_entry(k, part, 0);
  for (uint left = k.near_count[part.first / 16]; left; --left, entry += 16) {
    __builtin_prefetch(k.near + entry + slice); // the next slice, on a page of its own
    __builtin_prefetch(along + entry + slice);
    visit(entry);
  }
}

/// Calls work(std::bool_constant): whether the domain repeats.
template <class View, class Work> PLIANT_INLINE void with_images(const View& k, Work work) {
  if (k.period_x > 0 || k.period_y > 0 || k.period_z > 0)
    work(std::true_type());
  else
    work(std::false_type());
}

/// What leads from `own` places to others, as short as images make it where the domain `repeats`.
template <bool repeats = true, class View, class real = typename View::real>
PLIANT_INLINE Wide3<real> to_others(const View& k, const Wide4<real>& own, const Wide4<real>& others) {
  if constexpr (!repeats) return {others.x - own.x, others.y - own.y, others.z - own.z};
  return {shortest<real>(others.x - own.x, k.period_x), shortest<real>(others.y - own.y, k.period_y),
          shortest<real>(others.z - own.z, k.period_z)};
}

/// Weight of bonds of these squared lengths.
template <class View, class real = typename View::real>
PLIANT_INLINE Wide<real> bond_weights(const View& k, Wide<real> size2) {
  const Wide<real> one = Wide<real>{} + 1, all = size2 * k.per_reach2, q = all < one ? all : one,
                   left = one - q;
  return left * left * (k.weight_0 + q * (k.weight_2 + q * k.weight_4));
}

/// What stays of a neighbourhood's strain; see shaders/common/fluid_yield.glsl.
template <class real> struct Stays {
  real isotropic = 1, deviatoric = 1, strain = 0;
  bool yields = false;
};
template <class real>
PLIANT_INLINE Stays<real> what_stays(const Real4<real>& surface, real relaxed, real isotropic, real square,
                                     real strain_before, real equivalent) {
  Stays<real> stays;
  stays.deviatoric = relaxed;
  const real rms = relaxed * root(square);
  const real strength = surface.z + surface.w * strain_before,
             over = surface.x * rms - (strength - surface.y * isotropic);
  if (!(over > 0)) return stays;
  stays.yields = true;
  const real most = equivalent * rms;
  const real wanted = over / (surface.x / equivalent + surface.w);
  if (wanted < most) {
    stays.strain = wanted;
    stays.deviatoric = relaxed * (1 - wanted / most);
    return stays;
  }
  stays.strain = most;
  stays.deviatoric = 0;
  const real pull = surface.y * isotropic, beyond = pull - (strength + surface.w * most);
  if (beyond > 0) stays.isotropic = 1 - smaller(beyond / pull, real(1));
  return stays;
}

/// Averages over a particle's bonds, as sums and their weight.
template <class real> struct StrainSums { Wide<real> weight{}, strain{}, square{}; };
template <class real>
PLIANT_INLINE void add_strain(StrainSums<real>& sums, Wide<real> weight, Wide<real> strain) {
  sums.weight += weight;
  sums.strain += weight * strain;
  sums.square += weight * strain * strain;
}

} // namespace pliant::openmp::PLIANT_ISA
