// Forces of law M3, gathered; see kernels/stretch_force.decl.
#include "common/bonds.glsl"
#include "common/direction.glsl"
#include "common/basis.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || gate[0].x > 0.0) return; // SOLVER_STOP
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec4 ui = stretch_record[2 * i], yi = stretch_record[2 * i + 1];
  uint row_i = uint(yi.w);
  bool squared_i = energies[row_i].x > 0.0;
  vec3 sum = vec3(0.0);
  float stretching = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec4 uj = stretch_record[2 * j], yj = stretch_record[2 * j + 1];
    vec3 y = (yj.xyz - yi.xyz) + (uj.xyz - ui.xyz), xi = unpack_bond(bond[entry + 16], unit);
    float x = length(xi), per_x = x > 0.0 ? 1.0 / x : 0.0, size = length(y);
    float e = (size - x) * per_x, s = size * per_x;
    uint row_j = uint(yj.w);
    float h_i = 0.5 * basis_slopes(row_i + STRETCH_BOND, e).x;
    float h_j = row_j == row_i ? h_i : 0.5 * basis_slopes(row_j + STRETCH_BOND, e).x;
#if potential
    float own = weight[entry] * x * x * basis_value(row_i + STRETCH_BOND, e);
#if anisotropic
    own *= strength[entry];
#endif
    stretching += own;
#endif
#if anisotropic
    h_i *= strength[entry];
    h_j *= strength[entry + 16];
#endif
    float out_pull = ui.w * (squared_i ? s : 1.0) + h_i;
    float in_pull = uj.w * (energies[row_j].x > 0.0 ? s : 1.0) + h_j;
    sum += x * (weight[entry] * out_pull + weight[entry + 16] * in_pull) * bond_direction(y, xi);
  }
  force[i] = vec4(sum, linear_start[i].w);
#if potential
  energy[i] += 0.5 * stretching;
#endif
}
