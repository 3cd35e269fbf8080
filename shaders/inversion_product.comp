// See kernels/inversion_product.decl.
#include "common/bonds.glsl"
#include "common/cofactor.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 pi = direction[i].xyz;
  mat3 s = mat3(0.0), b = mat3(0.0);
  if (inverted[i] > 0.0) {
    for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
      uint entry = 32 * row + lane;
      vec3 dp = direction[bond[entry]].xyz - pi;
      s += outerProduct(weight[entry] * dp, unpack_bond(bond[entry + 16], unit));
    }
    mat3 inverse_shape = symmetric(inversion_shape[3 * stride + i], inversion_shape[4 * stride + i],
                                   inversion_shape[5 * stride + i], inversion_shape[6 * stride + i],
                                   inversion_shape[7 * stride + i], inversion_shape[8 * stride + i]);
    b = (inversion_shape[stride + i] * inversion_shape[i] * s) * inverse_shape * inverse_shape;
  }
  inversion[3 * i] = vec4(b[0][0], b[1][0], b[2][0], 0.0);
  inversion[3 * i + 1] = vec4(b[0][1], b[1][1], b[2][1], 0.0);
  inversion[3 * i + 2] = vec4(b[0][2], b[1][2], b[2][2], 0.0);
}
