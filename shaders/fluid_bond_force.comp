// Forces of bonds between fluids; see kernels/fluid_bond_force.decl.
#include "common/fluid_bond.glsl"
#include "common/fluid_bond_weight.glsl"
#include "common/near.glsl"
#include "common/solver.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads || solver[SOLVER_STOP] > 0.0) return;
  vec4 own = fluid_stay[i], f = vec4(0.0);
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = own.z > 0.0 ? near_count[slice] : 0u;
  vec3 yi = fluid_start[i].xyz, ui = fluid_displacement[i].xyz, period = vec3(period_x, period_y, period_z);
  for (uint r = 0u; r < count; ++r) {
    uint entry = first + 16u * r, j = near[entry];
    float rest = near_rest[entry];
    if (!(rest > 0.0)) continue;
    vec3 from = shortest(fluid_start[j].xyz - yi, period), y = from + (fluid_displacement[j].xyz - ui);
    vec4 other = fluid_stay[j];
    float size = length(y), e = (size - rest) / rest, share = bond_weight(from) / rest;
    float pull = own.z * (own.x * e + own.y) + other.z * (other.x * e + other.y);
    f.xyz += (share * pull / max(size, SHORTEST_BOND)) * y;
    f.w += share / rest * (own.z + other.z);
  }
  fluid_force[i] = vec4(f.xyz, own.x == 0.0 && own.z == 0.0 ? -1.0 : bound * f.w);
}
