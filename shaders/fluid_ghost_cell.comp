// Cells of ghosts; see kernels/fluid_ghost_cell.decl.
#include "common/lattice.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 place = ghost_place[i];
  uvec3 cells = uvec3(cells_x, cells_y, cells_z);
  uint cell = cells.x * cells.y * cells.z;
  if (place.w != 0.0) cell = lattice_cell(place.xyz, vec3(per_cell_x, per_cell_y, per_cell_z), cells);
  cell_of[particle_count + i] = cell;
  atomicAdd(cell_count[cell], 1u);
}
