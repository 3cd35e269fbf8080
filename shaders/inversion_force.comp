// Forces against inversion, gathered; see kernels/inversion_force.decl.
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
  vec4 i0 = inversion[3 * i], i1 = inversion[3 * i + 1], i2 = inversion[3 * i + 2];
  vec4 sum = vec4(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec4 j0 = inversion[3 * j], j1 = inversion[3 * j + 1], j2 = inversion[3 * j + 2];
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    float c_out = weight[entry], c_in = weight[entry + 16];
    sum.xyz += vec3(dot(c_out * i0.xyz + c_in * j0.xyz, xi), dot(c_out * i1.xyz + c_in * j1.xyz, xi),
                    dot(c_out * i2.xyz + c_in * j2.xyz, xi));
    sum.w += c_out * i0.w + c_in * j0.w;
  }
#if product
  sum.w = 0.0;
#endif
  force[i] += sum;
}
