// See kernels/coarse_matrix.decl.
#include "common/rotation.glsl"
#include "common/solver.glsl"

void add(uint at, mat3 k) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) matrix[at + 16u * uint(3 * r + c)] += k[c][r];
}

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_TAKEN] == 0.0 || solver[SOLVER_LINEAR] == 0.0) return;
  uint n = first_node + local, slice = n / 16u, lane = n % 16u;
  uint base = slice * 27u * 144u + lane;
  for (uint k = 0u; k < 243u; ++k) matrix[base + 16u * k] = 0.0;
  for (uint c = 0u; c < 8u; ++c) {
    uint at = cell[(slice * 8u + c) * 16u + lane];
    if (at == 0xffffffffu) continue;
    uint a = 7u - c, table = (signature[at] * 64u + 8u * a) * 12u;
#if rotated
    vec4 q = cell_rotation[at];
    mat3 rotation = rotation_matrix(q * inversesqrt(max(dot(q, q), 1e-30)));
#endif
    for (uint b = 0u; b < 8u; ++b, table += 12u) {
      // m[column][row]
      mat3 m = mat3(stiffness[table], stiffness[table + 3u], stiffness[table + 6u],
                    stiffness[table + 1u], stiffness[table + 4u], stiffness[table + 7u],
                    stiffness[table + 2u], stiffness[table + 5u], stiffness[table + 8u]);
      float trace = m[0][0] + m[1][1] + m[2][2], ratio = stiffness[table + 10u];
      float diagonal = trace + per_step2 * stiffness[table + 9u];
#if rotated
      mat3 turned = rotation * m * transpose(rotation);
      mat3 block = transpose(turned) + ratio * turned + mat3(diagonal);
#else
      mat3 block = mat3(diagonal + (1.0 + ratio) * trace);
#endif
      uint x = (c & 1u) + (b & 1u), y = (c >> 1 & 1u) + (b >> 1 & 1u), z = (c >> 2) + (b >> 2);
      add(base + (x + 3u * y + 9u * z) * 144u, block);
    }
  }
  uint own = base + 13u * 144u;
#if obstacles
  vec4 d = coarse_block[2u * n], e = coarse_block[2u * n + 1u];
  add(own, mat3(d.x, d.y, d.z, d.y, d.w, e.x, d.z, e.x, e.y));
#endif
  mat3 k;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) k[c][r] = matrix[own + 16u * uint(3 * r + c)];
  mat3 adjugate = mat3(cross(k[1], k[2]), cross(k[2], k[0]), cross(k[0], k[1])); // columns: rows of the inverse
  float det = dot(k[0], adjugate[0]);
  float scale = det > 0.0 ? 1.0 / det : 0.0;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) inverse_block[slice * 144u + 16u * uint(3 * r + c) + lane] = scale * adjugate[r][c];
}
