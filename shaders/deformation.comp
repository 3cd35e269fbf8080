// The deformation gradient of each particle; see kernels/deformation.decl.
#include "common/bonds.glsl"
#include "common/rotation.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz;
  mat3 yx = mat3(0.0), xx = mat3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    yx += outerProduct(weight[entry] * (position[bond[entry]].xyz - yi), xi);
    xx += outerProduct(weight[entry] * xi, xi);
  }
  float trace = xx[0][0] + xx[1][1] + xx[2][2];
  mat3 f = mat3(1.0);
  if (trace > 0.0) {
    yx /= trace;
    xx /= trace;
    mat3 r = rotation_matrix(horn_rotation(yx));
    f = (yx + 1e-3 * r) * inverse(xx + mat3(1e-3));
  }
  mat3 e = 0.5 * (transpose(f) * f - mat3(1.0));
  float mean = (e[0][0] + e[1][1] + e[2][2]) / 3.0;
  e -= mat3(mean);
  float strain = sqrt(2.0 / 3.0 * (dot(e[0], e[0]) + dot(e[1], e[1]) + dot(e[2], e[2])));
  gradient[3 * i] = vec4(f[0][0], f[1][0], f[2][0], strain);
  gradient[3 * i + 1] = vec4(f[0][1], f[1][1], f[2][1], 0.0);
  gradient[3 * i + 2] = vec4(f[0][2], f[1][2], f[2][2], 0.0);
}
