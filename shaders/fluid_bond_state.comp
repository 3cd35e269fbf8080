// Law M2 with what flows; see kernels/fluid_bond_state.decl.
#include "common/fluid_bond.glsl"
#include "common/fluid_bond_weight.glsl"
#include "common/fluid_yield.glsl"
#include "common/near.glsl"
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads || solver[SOLVER_STOP] > 0.0) return;
  vec4 stay = fluid_stay[i];
  if (!(stay.z > 0.0)) return;
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  vec3 yi = fluid_start[i].xyz, ui = fluid_displacement[i].xyz, period = vec3(period_x, period_y, period_z);
  float sum = 0.0, strains = 0.0, squares = 0.0;
  for (uint r = 0u; r < count; ++r) {
    uint entry = first + 16u * r, j = near[entry];
    float rest = near_rest[entry];
    if (!(rest > 0.0)) continue;
    vec3 from = shortest(fluid_start[j].xyz - yi, period), y = from + (fluid_displacement[j].xyz - ui);
    float w = bond_weight(from), e = (length(y) - rest) / rest;
    sum += w;
    strains += w * e;
    squares += w * e * e;
  }
  float per = sum > 0.0 ? 1.0 / sum : 0.0, isotropic = strains * per;
  uint row = ELASTIC_ROWS * uint(stay.w);
  vec4 bonds = fluid_elastic[row + ELASTIC_BONDS];
#if plastic
  float square = max(squares * per - isotropic * isotropic, 0.0);
  vec4 stays = what_stays(fluid_elastic[row + ELASTIC_YIELD], bonds.z, isotropic, square, fluid_flow[2u * i].x, equivalent);
#else
  vec4 stays = vec4(1.0, 1.0, 0.0, 0.0);
#endif
  fluid_stay[i] = vec4(stays.y, (bonds.y * stays.x - stays.y) * isotropic, bonds.x / max(sum, FULL_BONDS), stay.w);
}
