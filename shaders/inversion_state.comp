// What pushes an inverted neighbourhood back; see kernels/inversion_state.decl.
#include "common/bonds.glsl"
#include "common/cofactor.glsl"
#include "common/rotation.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_STOP] > 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  mat3 s = mat3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    s += outerProduct(weight[entry] * y, unpack_bond(bond[entry + 16], unit));
  }
  float push = inversion_shape[stride + i], share = 0.0;
  mat3 b = mat3(0.0);
  if (push > 0.0) {
    mat3 inverse_shape = symmetric(inversion_shape[3 * stride + i], inversion_shape[4 * stride + i],
                                   inversion_shape[5 * stride + i], inversion_shape[6 * stride + i],
                                   inversion_shape[7 * stride + i], inversion_shape[8 * stride + i]);
    mat3 f = (inversion_shape[i] * s) * inverse_shape;
    mat3 off = f - clamp_singular_values(f, 0.1);
    b = (push * off) * inverse_shape;
    share = inner(off, off) > 0.0 ? inversion_shape[2 * stride + i] : 0.0;
  }
  inversion[3 * i] = vec4(b[0][0], b[1][0], b[2][0], share);
  inversion[3 * i + 1] = vec4(b[0][1], b[1][1], b[2][1], 0.0);
  inversion[3 * i + 2] = vec4(b[0][2], b[1][2], b[2][2], 0.0);
}
