// Forces of law M2, gathered; see kernels/ordinary_force.decl.
#include "common/bonds.glsl"
#include "common/direction.glsl"
#include "common/rest.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
#if plastic
  bool stopped = gate[0].x > 0.0; // SOLVER_STOP
#else
  bool stopped = solver[SOLVER_STOP] > 0.0;
#endif
  if (local >= threads || stopped) return;
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
    vec4 at_rest = bond_at_rest(entry);
    float x = length(xi), size = length(y), x_out = x * at_rest.z, x_in = x * at_rest.w;
    sum += (at_rest.x * (size - x_out + x_out * ui.w) + at_rest.y * (size - x_in + x_in * uj.w)) *
           bond_direction(y, xi);
  }
  force[i] = vec4(sum, linear_start[i].w);
}
