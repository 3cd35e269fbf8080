// What one step's solve keeps of the positions at its start; see kernels/corotated_begin.decl.
#include "common/bonds.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz;
  mat3 s = mat3(0.0);
  vec3 linear = vec3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    vec3 y = position[bond[entry]].xyz - yi;
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    float c_out = weight[entry], c_in = weight[entry + 16];
    s += outerProduct(c_out * y, xi);
    linear += (c_out + c_in) * y;
  }
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) shape[(3 * r + c + 2) * stride + i] = s[c][r];
  linear_start[i].xyz = linear;
}
