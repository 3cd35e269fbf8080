// See kernels/corotated_tangent.decl.
#include "common/bonds.glsl"
#include "common/rotation.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_TAKEN] == 0.0 || solver[SOLVER_LINEAR] == 0.0) return;
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
  vec4 q = rotation[i];
  mat3 u = transpose(rotation_matrix(q)) * s;
  float theta = u[0][0] + u[1][1] + u[2][2], coupling = shape[stride + i];
  float xx = theta - u[0][0], yy = theta - u[1][1], zz = theta - u[2][2];
  float xy = -0.5 * (u[0][1] + u[1][0]), xz = -0.5 * (u[0][2] + u[2][0]), yz = -0.5 * (u[1][2] + u[2][1]);
#if failing
  float rest = shape[share_row * stride + i];
#else
  float rest = 1.0;
#endif
  float scale = 1.0 - coupling * (theta - rest);
#if flat
  float kept = scale;
#else
  float kept = scale * 2.0 / 3.0;
#endif
  float lowest = solver[SOLVER_CONVEX] > 0.0 ? max(0.02, kept) : 0.02; // of an eigenvalue
  float least = min(xx - abs(xy) - abs(xz), min(yy - abs(xy) - abs(yz), zz - abs(xz) - abs(yz)));
  // Gershgorin's bound, then Newton's method on the characteristic polynomial, which nears the least root from below.
  float c1 = xx + yy + zz, c2 = xx * yy + yy * zz + zz * xx - xy * xy - xz * xz - yz * yz;
  float c3 = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  for (int k = 0; k < 8; ++k) {
    float slope = (3.0 * least - 2.0 * c1) * least + c2;
    least -= min(0.0, ((least - c1) * least + c2) * least - c3) / max(slope, 1e-6 * c1 * c1 + 1e-30);
  }
  float raise = max(0.0, lowest - least);
  xx += raise;
  yy += raise;
  zz += raise;
  float cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
  float f = 1.0 / (xx * cxx + xy * cxy + xz * cxz);
  tangent[4 * i] = q;
  tangent[4 * i + 1] = f * vec4(cxx, cxy, cxz, xx * zz - xz * xz);
  tangent[4 * i + 2] = vec4(f * (xy * xz - xx * yz), f * (xx * yy - xy * xy), scale, coupling);
  tangent[4 * i + 3] = vec4(shape[i], 0.0, 0.0, 0.0);
}
