// Cells of a fluid's particles; see kernels/fluid_cell.decl.
#include "common/fluid.glsl"
#include "common/lattice.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 y = position[i];
  uvec3 cells = uvec3(cells_x, cells_y, cells_z);
  uint cell = cells.x * cells.y * cells.z;
  if (y.w != 0.0) {
    vec3 start = (origin[fluid_kind[i] & FLUID_BODY].xyz - vec3(base_x, base_y, base_z)) + y.xyz;
    vec4 v = velocity[i];
    vec3 flown = v.xyz;
    if (!(v.w > FLUID_HELD * time_step)) flown += time_step * vec3(gravity_x, gravity_y, gravity_z);
    cell = lattice_cell(start + time_step * flown, vec3(per_cell_x, per_cell_y, per_cell_z), cells);
  }
  cell_of[i] = cell;
  atomicAdd(cell_count[cell], 1u);
}
