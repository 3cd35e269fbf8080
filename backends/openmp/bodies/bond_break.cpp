// Bonds that are too long; see kernels/bond_break.decl.
#include "kernels/bond_break.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void bond_break(const kernels::bond_break::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local, slice = k.first_slice + local / 16, lane = local % 16;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    const Real4<real> own = k.toughness[i];
    real lost = 0;
    bool changed = false;
    real share = 0, stiffness = 0;
    for (uint row = k.slice_begin[slice]; row < k.slice_begin[slice + 1]; ++row) {
      const std::size_t entry = std::size_t{32} * row + lane;
      const uint j = k.bond[entry];
      if (j == i) continue;
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
      const Vec3<real> xi = unpack_bond(k.bond[entry + 16], k.unit);
      const Real4<real> other = k.toughness[j];
      const real x2 = dot(xi, xi);
      const real c_out = k.weight[entry], c_in = k.weight[entry + 16];
      if (dot(y, y) > x2 * smaller(own.x, other.x)) {
        changed = true;
        if (c_out + c_in > 0) lost += 1;
        k.bond[entry] = i;
        k.bond[entry + 16] = 0;
        k.weight[entry] = 0;
        k.weight[entry + 16] = 0;
      } else {
        share += c_out * x2;
        stiffness += own.y * c_out + other.y * c_in;
      }
    }
    if (!changed) continue;
    k.shape[std::size_t{k.share_row} * k.stride + i] = k.shape[i] * share;
    k.shape[std::size_t{k.share_row + 1} * k.stride + i] += lost;
    k.linear_start[i].w = stiffness;
  }
}

PLIANT_BODY(bond_break)

} // namespace pliant::openmp::PLIANT_ISA
