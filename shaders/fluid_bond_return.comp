// The end of a step of bonded fluids; see kernels/fluid_bond_return.decl.
#include "common/fluid_bond.glsl"
#include "common/fluid_bond_weight.glsl"
#include "common/fluid_yield.glsl"
#include "common/near.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 stay = fluid_stay[i];
  float stored = 0.0;
  if (stay.z > 0.0) {
    uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
    vec3 start = fluid_start[i].xyz, yi = fluid_place[i].xyz, period = vec3(period_x, period_y, period_z);
    float sum = 0.0, strains = 0.0, squares = 0.0;
    for (uint r = 0u; r < count; ++r) {
      uint entry = first + 16u * r, j = near[entry];
      float rest = near_rest[entry];
      if (!(rest > 0.0)) continue;
      float w = bond_weight(shortest(fluid_start[j].xyz - start, period));
      float e = (length(shortest(fluid_place[j].xyz - yi, period)) - rest) / rest;
      sum += w;
      strains += w * e;
      squares += w * e * e;
    }
    float per = sum > 0.0 ? 1.0 / sum : 0.0, isotropic = strains * per;
    float square = max(squares * per - isotropic * isotropic, 0.0);
    uint row = ELASTIC_ROWS * uint(stay.w);
    vec4 bonds = fluid_elastic[row + ELASTIC_BONDS];
    vec4 stays = vec4(1.0, 1.0, 0.0, 0.0);
#if plastic
    vec4 so_far = fluid_flow[2u * i];
    stays = what_stays(fluid_elastic[row + ELASTIC_YIELD], bonds.z, isotropic, square, so_far.x, equivalent);
    // The stress that stays times the strain that flows.
    float taken = stay.z * sum *
                  (stays.y * (1.0 - stays.y) * square + bonds.y * stays.x * (1.0 - stays.x) * isotropic * isotropic);
    fluid_flow[2u * i] = vec4(so_far.x + stays.z, so_far.y + taken,
                              so_far.z + bonds.w * dimension * (1.0 - stays.x) * isotropic, stays.w);
    fluid_flow[2u * i + 1u] = vec4(isotropic, stays.xy, equivalent * (1.0 - stays.y) * sqrt(square));
#endif
    stored = 0.5 * stay.z * sum *
             (stays.y * stays.y * square + bonds.y * stays.x * stays.x * isotropic * isotropic);
  }
#if measured
  fluid_energy[i] = stored;
#endif
}
