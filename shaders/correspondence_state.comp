// Local step of law M5, neo-Hookean; see kernels/correspondence_state.decl.
#include "common/bonds.glsl"
#include "common/cofactor.glsl"
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
  mat3 inverse_shape = symmetric(shape[11 * stride + i], shape[12 * stride + i], shape[13 * stride + i],
                                 shape[14 * stride + i], shape[15 * stride + i], shape[16 * stride + i]);
  mat3 f = (shape[i] * s) * inverse_shape;
  mat3 cof = cofactor(f);
  float pressure = (1.0 + shape[stride + i] / 1.5) * (dot(f[0], cof[0]) - 1.0) - 1.0; // (lambda / mu)(J - alpha)
  mat3 a = f - (f + pressure * cof) * (inverse_shape / 3.0);
  rotation[i] = polar_rotation(f, rotation[i]);
  record[3 * i] = vec4(a[0][0], a[1][0], a[2][0], ui.x);
  record[3 * i + 1] = vec4(a[0][1], a[1][1], a[2][1], ui.y);
  record[3 * i + 2] = vec4(a[0][2], a[1][2], a[2][2], ui.z);
}
