// Rest lengths that go on; see kernels/fluid_bond_carry.decl.
#include "common/fluid_bond.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  uvec4 own = fluid_was[i];
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  uint slice_then = own.x / 16u, first_then = 16u * rows * slice_then + own.x % 16u;
  uint count_then = near_count_earlier[slice_then], at = 0u;
  for (uint r = 0u; r < count; ++r) {
    uint entry = first + 16u * r, j = near[entry];
    uvec4 other = fluid_was[j];
    float rest = 0.0;
    if (j != i && own.y != 0u && own.y != FAMILY_GHOST && (other.y == own.y || other.y == FAMILY_GHOST)) {
      rest = BOND_NEW;
      for (uint tried = 0u; tried < count_then; ++tried) {
        uint entry_then = first_then + 16u * at;
        at = at + 1u < count_then ? at + 1u : 0u;
        if (near_earlier[entry_then] != other.x || other.x == own.x) continue;
        float before = near_rest_earlier[entry_then];
        if (before > 0.0) rest = before;
        break;
      }
    }
    near_rest[entry] = rest;
  }
  if (own.w != 0u) near_place_of[own.z] = i;
}
