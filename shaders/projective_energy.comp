// Eq. 8 of He, Wang, Wu 2017 at each particle; see kernels/projective_energy.decl.
#include "common/bonds.glsl"

void main() {
#if gated
  if (gate[0].x > 0.0) return; // SOLVER_STOP
#endif
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz;
  vec4 i0 = record[3 * i], i1 = record[3 * i + 1], i2 = record[3 * i + 2];
  float sum = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + vec3(record[3 * j].w - i0.w, record[3 * j + 1].w - i1.w, record[3 * j + 2].w - i2.w);
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    float x = length(xi);
    float affine = length(vec3(dot(i0.xyz, xi), dot(i1.xyz, xi), dot(i2.xyz, xi))) - x, direct = length(y) - x;
    sum += weight[entry] * (deviatoric * affine * affine + (1.0 - deviatoric) * direct * direct);
  }
  energy[i] = 0.5 * sum;
}
