// Lists of neighbours; see kernels/near_find.decl.
#include "common/lattice.glsl"
#include "common/near.glsl"

shared uint longest[8]; // of the slices of a group

uint first_cell(uint at, uint cells) { return cells < 3u ? 0u : at + cells - 1u; }

void main() {
  uint i = thread_index(), slice_here = local_index() / 16u;
  if (local_index() < 8u) longest[local_index()] = 0u;
  barrier();
  bool mine = i < places;
  vec4 own = mine ? fluid_place[i] : vec4(0.0);
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = 0u, lost = 0u;
  if (own.w > 0.0 || (own.w < 0.0 && fluid_particle[i] < particle_count)) {
    uvec3 cells = uvec3(cells_x, cells_y, cells_z);
    vec3 period = vec3(period_x, period_y, period_z);
    uint x = wrapped(lattice_coordinate(own.x, per_cell_x), cells.x);
    uint y = wrapped(lattice_coordinate(own.y, per_cell_y), cells.y);
    uint z = wrapped(lattice_coordinate(own.z, per_cell_z), cells.z);
    // A row is one run of cells, or two where it goes round.
    uint left = first_cell(x, cells.x), width = min(cells.x, 3u);
    uint from[2], to[2], runs = 1u;
    left = left % cells.x;
    from[0] = left;
    to[0] = min(left + width, cells.x);
    if (left + width > cells.x) {
      from[1] = 0u;
      to[1] = left + width - cells.x;
      runs = 2u;
    }
    for (uint dz = 0u; dz < min(cells.z, 3u); ++dz)
      for (uint dy = 0u; dy < min(cells.y, 3u); ++dy) {
        uint row = ((first_cell(z, cells.z) + dz) % cells.z * cells.y + (first_cell(y, cells.y) + dy) % cells.y) * cells.x;
        for (uint run = 0u; run < runs; ++run)
          for (uint j = cell_begin[row + from[run]]; j < cell_begin[row + to[run]]; ++j) {
            if (j == i) continue;
            vec4 other = fluid_place[j];
            vec3 d = shortest(own.xyz - other.xyz, period);
            if (!(dot(d, d) < reach * reach) || other.w == 0.0) continue;
            if (count < rows) near[first + 16u * count++] = j;
            else ++lost;
          }
      }
  }
  if (mine) atomicMax(longest[slice_here], count);
  barrier();
  if (!mine) return;
  uint all = longest[slice_here];
  for (uint r = count; r < all; ++r) near[first + 16u * r] = i;
  if (i % 16u == 0u) near_count[slice] = all;
  if (lost > 0u) {
    atomicAdd(left_out[0], lost);
    atomicAdd(left_out[1], 1u);
  }
}
