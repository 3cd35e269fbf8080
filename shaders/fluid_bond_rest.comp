// Rest lengths of new bonds; see kernels/fluid_bond_rest.decl.
#include "common/fluid_bond.glsl"
#include "common/near.glsl"

// |X|^2 / |Y|^2 that an end finds along y; the same for -y.
float ratio_of(uint i, vec3 y) {
  vec4 a = fluid_fit[2u * i], b = fluid_fit[2u * i + 1u];
  precise float size2 = (y.x * y.x + y.y * y.y) + y.z * y.z;
  precise float straight = (a.x * (y.x * y.x) + a.y * (y.y * y.y)) + a.z * (y.z * y.z);
  precise float mixed = (a.w * (y.y * y.z) + b.x * (y.x * y.z)) + b.y * (y.x * y.y);
  precise float ratio = (straight + 2.0 * mixed) / size2;
  precise float least = 1.0 / (b.w * b.w), largest = 1.0 / (b.z * b.z);
  return ratio > least ? min(ratio, largest) : least;
}

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  vec3 yi = fluid_start[i].xyz, period = vec3(period_x, period_y, period_z);
  for (uint r = 0u; r < count; ++r) {
    uint entry = first + 16u * r, j = near[entry];
    if (!(near_rest[entry] < 0.0)) continue;
    precise vec3 y = shortest(fluid_start[j].xyz - yi, period);
    precise float size2 = (y.x * y.x + y.y * y.y) + y.z * y.z, rest = least_rest;
    if (size2 > least_rest * least_rest) {
      precise float own = ratio_of(i, y), other = fluid_was[j].y == FAMILY_GHOST ? own : ratio_of(j, y);
      rest = max(sqrt(size2 * (0.5 * (own + other))), least_rest);
    }
    near_rest[entry] = rest;
  }
}
