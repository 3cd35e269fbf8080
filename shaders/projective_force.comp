// Forces of law M1, gathered; see kernels/projective_force.decl.
#include "common/bonds.glsl"
#include "common/direction.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_STOP] > 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz;
  vec4 i0 = record[3 * i], i1 = record[3 * i + 1], i2 = record[3 * i + 2];
  vec3 sum = vec3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec4 j0 = record[3 * j], j1 = record[3 * j + 1], j2 = record[3 * j + 2];
    vec3 y = (position[j].xyz - yi) + vec3(j0.w - i0.w, j1.w - i1.w, j2.w - i2.w);
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    float x = length(xi);
    vec3 from_i = bond_direction(vec3(dot(i0.xyz, xi), dot(i1.xyz, xi), dot(i2.xyz, xi)), xi);
    vec3 from_j = bond_direction(vec3(dot(j0.xyz, xi), dot(j1.xyz, xi), dot(j2.xyz, xi)), xi);
    vec3 direct = (1.0 - deviatoric) * bond_direction(y, from_i + from_j);
    float c_out = weight[entry], c_in = weight[entry + 16];
    sum += c_out * (y - x * (deviatoric * from_i + direct)) + c_in * (y - x * (deviatoric * from_j + direct));
  }
  force[i] = vec4(sum, linear_start[i].w);
}
