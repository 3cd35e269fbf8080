// Forces of law M4, gathered; see kernels/corotated_force.decl.
#include "common/bonds.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
#if product
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
#else
  if (local >= threads || solver[SOLVER_STOP] > 0.0) return;
#endif
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec4 i0 = record[3 * i], i1 = record[3 * i + 1], i2 = record[3 * i + 2];
  vec3 linear = vec3(0.0), rest = vec3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec4 j0 = record[3 * j], j1 = record[3 * j + 1], j2 = record[3 * j + 2];
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    float c_out = weight[entry], c_in = weight[entry + 16];
    linear += (c_out + c_in) * vec3(j0.w - i0.w, j1.w - i1.w, j2.w - i2.w);
    rest += vec3(dot(c_out * i0.xyz + c_in * j0.xyz, xi), dot(c_out * i1.xyz + c_in * j1.xyz, xi),
                 dot(c_out * i2.xyz + c_in * j2.xyz, xi));
  }
#if product
  vec4 start = vec4(0.0);
#else
  vec4 start = linear_start[i];
#endif
  force[i] = vec4(start.xyz + linear - rest, start.w);
}
