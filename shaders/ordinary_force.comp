// Forces of law M2, gathered; see kernels/ordinary_force.decl.
#include "common/bonds.glsl"
#include "common/direction.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_STOP] > 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz;
  vec4 ui = extension[i];
  vec3 sum = vec3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec4 uj = extension[j];
    vec3 y = (position[j].xyz - yi) + (uj.xyz - ui.xyz);
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    float x = length(xi), stretch = length(y) - x;
    float c_out = weight[entry], c_in = weight[entry + 16];
    sum += (c_out * (stretch + x * ui.w) + c_in * (stretch + x * uj.w)) * bond_direction(y, xi);
  }
  force[i] = vec4(sum, linear_start[i].w);
}
