// Rest lengths at the end of a step; see kernels/fluid_bond_flow.decl. Both particles of a bond compute them: no rounding may
// depend on whose list it is.
#include "common/fluid_bond.glsl"
#include "common/near.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  vec3 before = fluid_before[i].xyz, period = vec3(period_x, period_y, period_z);
#if plastic
  vec4 own = fluid_flow[2u * i + 1u];
#endif
  for (uint r = 0u; r < count; ++r) {
    uint entry = first + 16u * r, j = near[entry];
    precise float rest = near_rest[entry];
    if (!(rest > 0.0)) continue;
    vec4 there = fluid_before[j];
    precise vec3 y = shortest(there.xyz - before, period);
    precise float size = sqrt((y.x * y.x + y.y * y.y) + y.z * y.z);
#if plastic
    vec4 other = there.w < 0.0 && fluid_was[j].y == FAMILY_GHOST ? own : fluid_flow[2u * j + 1u];
    if (own.y < 1.0 || own.z < 1.0 || other.y < 1.0 || other.z < 1.0) {
      precise float strain = (size - rest) / rest;
      precise float by_own = own.y * own.x + own.z * (strain - own.x);
      precise float by_other = other.y * other.x + other.z * (strain - other.x);
      precise float stretch = 1.0 + 0.5 * (by_own + by_other);
      rest = size / max(stretch, 0.05);
    }
#endif
#if spread
    precise vec3 now = shortest(fluid_place[j].xyz - fluid_place[i].xyz, period);
    precise float size_now = sqrt((now.x * now.x + now.y * now.y) + now.z * now.z);
    if (size > least_rest && size_now != size) rest = rest * (size_now / size);
#endif
    near_rest[entry] = clamp(rest, least_rest, largest_rest);
  }
}
