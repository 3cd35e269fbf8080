// See kernels/stretch_product_force.decl.
#include "common/bonds.glsl"
#include "common/direction.glsl"
#include "common/basis.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec4 yi = tangent[4 * i], pi = stretch_record[2 * i];
  uint row_i = uint(tangent[4 * i + 1].x);
  bool squared_i = energies[row_i].x > 0.0, convex = solver[SOLVER_CONVEX] > 0.0;
  vec3 sum = vec3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec4 yj = tangent[4 * j], pj = stretch_record[2 * j];
    uint row_j = uint(tangent[4 * j + 1].x);
    bool squared_j = energies[row_j].x > 0.0;
    vec3 xi = unpack_bond(bond[entry + 16], unit), y = yj.xyz - yi.xyz, dy = pj.xyz - pi.xyz;
    float x = length(xi), per_x = x > 0.0 ? 1.0 / x : 0.0, size = length(y);
    float e = (size - x) * per_x, s = size * per_x, s_i = squared_i ? s : 1.0, s_j = squared_j ? s : 1.0;
    float c_out = weight[entry], c_in = weight[entry + 16];
    vec2 h_i = 0.5 * basis_slopes(row_i + STRETCH_BOND, e);
    vec2 h_j = row_j == row_i ? h_i : 0.5 * basis_slopes(row_j + STRETCH_BOND, e);
#if anisotropic
    h_i *= strength[entry];
    h_j *= strength[entry + 16];
#endif
    vec3 n = bond_direction(y, xi);
    float along = dot(n, dy);
    float pull = x * (c_out * (yi.w * s_i + h_i.x) + c_in * (yj.w * s_j + h_j.x));
    float stiffness = c_out * ((squared_i ? yi.w : 0.0) + h_i.y) + c_in * ((squared_j ? yj.w : 0.0) + h_j.y);
    float across = pull / max(size, 1e-3 * x + 1e-30);
    if (convex) {
      stiffness = max(stiffness, 0.0);
      across = max(across, 0.0);
    }
    sum += (stiffness * along + x * (c_out * pi.w * s_i + c_in * pj.w * s_j)) * n + across * (dy - along * n);
  }
  force[i] = vec4(sum, 0.0);
}
