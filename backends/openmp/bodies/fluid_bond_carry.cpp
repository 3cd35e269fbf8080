// Rest lengths that go on; see kernels/fluid_bond_carry.decl.
#include "kernels/fluid_bond_carry.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/fluid_bond.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_bond_carry(const kernels::fluid_bond_carry::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < (k.threads + 15) / 16; ++slice) {
    const uint count = k.near_count[slice], last = smaller(16 * slice + 16, k.threads);
    for (uint i = 16 * slice; i < last; ++i) {
      const auto own = k.fluid_was[i];
      const bool bonds = own.y != 0 && own.y != FAMILY_GHOST;
      const uint count_then = k.near_count_earlier[own.x / 16];
      const std::size_t first_then = std::size_t{16} * k.rows * (own.x / 16) + own.x % 16;
      const uint* const list_then = k.near_earlier + first_then;
      const real* const rest_then = k.near_rest_earlier + first_then;
      uint at = 0;
      for (uint r = 0; r < count; ++r) {
        const std::size_t entry = std::size_t{16} * (std::size_t{k.rows} * slice + r) + i % 16;
        const uint j = k.near[entry];
        const auto other = k.fluid_was[j];
        if (j == i || !bonds || (other.y != own.y && other.y != FAMILY_GHOST)) {
          k.near_rest[entry] = 0;
          continue;
        }
        real rest = BOND_NEW;
        for (uint tried = 0; tried < count_then; ++tried) {
          const std::size_t row = std::size_t{16} * at;
          if (++at == count_then) at = 0;
          if (list_then[row] == other.x && other.x != own.x) {
            if (rest_then[row] > 0) rest = rest_then[row];
            break;
          }
        }
        k.near_rest[entry] = rest;
      }
      if (own.w) k.near_place_of[own.z] = i;
    }
  }
}

PLIANT_BODY(fluid_bond_carry)

} // namespace pliant::openmp::PLIANT_ISA
