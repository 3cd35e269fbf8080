// Local step of law M4; see kernels/corotated_state.decl.
#include "common/bonds.glsl"
#include "common/rotation.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_STOP] > 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 ui = displacement[i].xyz;
  mat3 s;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) s[c][r] = shape[(3 * r + c + 2) * stride + i];
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    vec3 du = displacement[bond[entry]].xyz - ui;
    s += outerProduct(weight[entry] * du, unpack_bond(bond[entry + 16], unit));
  }
  s *= shape[i];
#if plane
  vec4 q = plane_rotation(s, rotation[i]);
#else
  vec4 q = polar_rotation(s, rotation[i]);
#endif
  mat3 r = rotation_matrix(q);
  float theta = dot(r[0], s[0]) + dot(r[1], s[1]) + dot(r[2], s[2]);
#if failing
  float rest = shape[share_row * stride + i];
#else
  float rest = 1.0;
#endif
  mat3 a = (1.0 - shape[stride + i] * (theta - rest)) * r;
  rotation[i] = q;
  record[3 * i] = vec4(a[0][0], a[1][0], a[2][0], ui.x);
  record[3 * i + 1] = vec4(a[0][1], a[1][1], a[2][1], ui.y);
  record[3 * i + 2] = vec4(a[0][2], a[1][2], a[2][2], ui.z);
}
