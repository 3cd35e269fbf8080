// See kernels/corotated_product.decl.
#include "common/bonds.glsl"
#include "common/rotation.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 pi = direction[i].xyz;
  mat3 s = mat3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    vec3 dp = direction[bond[entry]].xyz - pi;
    s += outerProduct(weight[entry] * dp, unpack_bond(bond[entry + 16], unit));
  }
  vec4 a = tangent[4 * i + 1], b = tangent[4 * i + 2];
  mat3 r = rotation_matrix(tangent[4 * i]), m = transpose(r) * (tangent[4 * i + 3].x * s);
  vec3 axial = vec3(m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]);
  vec3 w = b.z * vec3(a.x * axial.x + a.y * axial.y + a.z * axial.z, a.y * axial.x + a.w * axial.y + b.x * axial.z,
                      a.z * axial.x + b.x * axial.y + b.y * axial.z);
  float t = -b.w * (m[0][0] + m[1][1] + m[2][2]);
  mat3 da = r * mat3(t, w.z, -w.y, -w.z, t, w.x, w.y, -w.x, t);
  record[3 * i] = vec4(da[0][0], da[1][0], da[2][0], pi.x);
  record[3 * i + 1] = vec4(da[0][1], da[1][1], da[2][1], pi.y);
  record[3 * i + 2] = vec4(da[0][2], da[1][2], da[2][2], pi.z);
}
