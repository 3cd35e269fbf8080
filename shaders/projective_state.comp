// Local step of law M1; see kernels/projective_state.decl.
#include "common/bonds.glsl"
#include "common/rotation.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_STOP] > 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  mat3 yx = mat3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    yx += outerProduct(weight[entry] * dot(xi, xi) * y, xi);
  }
  float kxx = shape[2 * stride + i], kxy = shape[3 * stride + i], kxz = shape[4 * stride + i];
  float kyy = shape[5 * stride + i], kyz = shape[6 * stride + i], kzz = shape[7 * stride + i];
  mat3 f = yx * mat3(kxx, kxy, kxz, kxy, kyy, kyz, kxz, kyz, kzz);
#if swap_rows
  if (determinant(f) < 0.0) f = mat3(f[0].yxz, f[1].yxz, f[2].yxz);
#else
  f = clamp_singular_values(f, 0.1);
#endif
  record[3 * i] = vec4(f[0][0], f[1][0], f[2][0], ui.x);
  record[3 * i + 1] = vec4(f[0][1], f[1][1], f[2][1], ui.y);
  record[3 * i + 2] = vec4(f[0][2], f[1][2], f[2][2], ui.z);
}
