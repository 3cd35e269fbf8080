// See kernels/correspondence_tangent.decl.
#include "common/bonds.glsl"
#include "common/cofactor.glsl"
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
  mat3 f = (shape[i] * s) * symmetric(shape[11 * stride + i], shape[12 * stride + i], shape[13 * stride + i],
                                      shape[14 * stride + i], shape[15 * stride + i], shape[16 * stride + i]);
  float stiffness = 1.0 + shape[stride + i] / 1.5; // lambda / mu
  float pressure = stiffness * (determinant(f) - 1.0) - 1.0, raise = 0.0;
  if (solver[SOLVER_CONVEX] > 0.0) {
    mat3 u = transpose(rotation_matrix(rotation[i])) * f, v;
    vec3 sigma, least;
    symmetric_eigen(0.5 * (u + transpose(u)), sigma, v);
    vec3 g = vec3(sigma.y * sigma.z, sigma.x * sigma.z, sigma.x * sigma.y);
    mat3 block = mat3(1.0) + stiffness * outerProduct(g, g) +
                 pressure * symmetric(0.0, sigma.z, sigma.y, 0.0, sigma.x, 0.0);
    symmetric_eigen(block, least, v);
    float twist = 1.0 - abs(pressure) * max(abs(sigma.x), max(abs(sigma.y), abs(sigma.z)));
    raise = max(0.0, -min(twist, min(least.x, min(least.y, least.z))));
  }
  tangent[4 * i] = vec4(f[0][0], f[1][0], f[2][0], pressure);
  tangent[4 * i + 1] = vec4(f[0][1], f[1][1], f[2][1], raise);
  tangent[4 * i + 2] = vec4(f[0][2], f[1][2], f[2][2], 0.0);
}
