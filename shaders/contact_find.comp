// Contacts of each particle; see kernels/contact_find.decl.
#include "common/bonds.glsl"
#include "common/cells.glsl"
#include "common/contact.glsl"

#if within
uint slice_of(uint i, out uint lane) {
  uint range = 0u;
  while (range < 3u && i - law_range[range].x >= law_range[range].y) ++range;
  uint local = i - law_range[range].x;
  lane = local % SLICE;
  return law_range[range].z + local / SLICE;
}

bool bonded(uint slice, uint lane, uint j) {
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row)
    if (bond[32 * row + lane] == j) return true;
  return false;
}
#endif

void main() {
  uint k = thread_index();
  if (k >= threads) return;
  uint i = sorted[k];
  vec4 here = sorted_place[k];
  ivec3 home = cell_at(here.xyz, per_cell);
  bool own = false;
#if within
  own = self_contact[uint(here.w)] != 0u;
  uint lane, slice = slice_of(i, lane);
#endif
  uint found = 0u, lost = 0u;
  uint near[CONTACTS];
  float far2[CONTACTS];
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy) {
      // Three cells along x; their numbers may run over the end of the table.
      uint first = cell_number(ivec3(home.x - 1, home.y + dy, home.z + dz), mask);
      for (uint part = 0u; part < 2u; ++part) {
        uint low = part == 0u ? first : 0u;
        uint high = part == 0u ? min(first + 3u, mask + 1u) : max(first + 3u, mask + 1u) - (mask + 1u);
        if (low >= high) continue;
        for (uint other = cell_begin[low]; other < cell_begin[high]; ++other) {
          vec4 there = sorted_place[other];
          bool same = there.w == here.w;
          if (same ? !own : between == 0) continue;
          vec3 y = there.xyz - here.xyz;
          float r2 = dot(y, y);
          if (!(r2 < reach * reach) || other == k) continue;
          // Rows may share numbers: only true members of this row count, and so each once.
          ivec3 cell = cell_at(there.xyz, per_cell);
          if (cell.y != home.y + dy || cell.z != home.z + dz || abs(cell.x - home.x) > 1) continue;
          uint j = sorted[other];
#if within
          if (same && bonded(slice, lane, j)) continue;
#endif
          uint at = found;
          if (found == CONTACTS) {
            ++lost;
            if (r2 > far2[CONTACTS - 1] || (r2 == far2[CONTACTS - 1] && j > near[CONTACTS - 1])) continue;
            at = CONTACTS - 1u;
          } else {
            ++found;
          }
          while (at > 0u && (r2 < far2[at - 1u] || (r2 == far2[at - 1u] && j < near[at - 1u]))) {
            near[at] = near[at - 1u];
            far2[at] = far2[at - 1u];
            --at;
          }
          near[at] = j;
          far2[at] = r2;
        }
      }
    }
  // By index: a sum's order must not depend on how the cloud lies.
  for (uint a = 1u; a < found; ++a) {
    uint j = near[a], at = a;
    for (; at > 0u && near[at - 1u] > j; --at) near[at] = near[at - 1u];
    near[at] = j;
  }
  uint base = CONTACTS * SLICE * (i / SLICE) + i % SLICE;
  for (uint a = 0u; a < found; ++a) contact[base + SLICE * a] = near[a];
  if (found < CONTACTS) contact[base + SLICE * found] = i;
  if (lost > 0u) {
    atomicAdd(left_out[0], lost);
    atomicAdd(left_out[1], 1u);
  }
}
