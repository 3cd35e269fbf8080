// Rest lengths of new bonds; see kernels/fluid_bond_rest.decl.
#include "kernels/fluid_bond_rest.h"
#include "backends/openmp/body.h"
#include "backends/openmp/fluid_bonds.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// |X|^2 / |Y|^2 that an end finds along y; the same for -y.
template <class real> PLIANT_INLINE real ratio_of(const Real4<real>* fit, Vec3<real> y) {
  const real straight = fit[0].x * (y.x * y.x) + fit[0].y * (y.y * y.y) + fit[0].z * (y.z * y.z);
  const real mixed = fit[0].w * (y.y * y.z) + fit[1].x * (y.x * y.z) + fit[1].y * (y.x * y.y);
  const real ratio = (straight + 2 * mixed) / dot(y, y);
  const real least = 1 / (fit[1].w * fit[1].w), largest = 1 / (fit[1].z * fit[1].z);
  return ratio > least ? smaller(ratio, largest) : least;
}

} // namespace

template <class real> void fluid_bond_rest(const kernels::fluid_bond_rest::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    for (uint r = 0; r < k.near_count[first / 16]; ++r) {
      const std::size_t entry = list_entry(k, part, r);
      uint fresh = bits<real>(load_wide(k.near_rest + entry) < 0);
      if (!fresh) continue;
      const Wide3<real> away =
          to_others(k, gather(k.fluid_start, part.index), gather(k.fluid_start, k.near + entry));
      for (; fresh; fresh &= fresh - 1) {
        const auto lane = static_cast<uint>(__builtin_ctz(fresh));
        if (lane >= part.count) break;
        const uint i = first + lane, j = k.near[entry + lane];
        const Vec3<real> y{away.x[lane], away.y[lane], away.z[lane]};
        const real size2 = dot(y, y);
        real rest = k.least_rest;
        if (size2 > rest * rest) {
          const real own = ratio_of(k.fluid_fit + 2 * std::size_t{i}, y);
          const bool ghost = k.fluid_was[j].y == FAMILY_GHOST;
          const real other = ghost ? own : ratio_of(k.fluid_fit + 2 * std::size_t{j}, y);
          rest = larger(rest, root(size2 * (real(0.5) * (own + other))));
        }
        k.near_rest[entry + lane] = rest;
      }
    }
  }
}

PLIANT_BODY(fluid_bond_rest)

} // namespace pliant::openmp::PLIANT_ISA
