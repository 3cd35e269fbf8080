// Box of positions and range of the field. Floats are mapped to unsigned numbers of the same order, so that the
// result does not depend on who comes first.
layout(local_size_x = 128) in;
layout(std430, binding = 0) readonly buffer point_block { vec4 points[]; };
layout(std430, binding = 1) buffer bounds_block { uint low[4], high[4]; };

uniform uint first_point, count;
shared uint group_low[4], group_high[4];

uint ordered(float value) {
  uint bits = floatBitsToUint(value);
  return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

void main() {
  uint local = gl_LocalInvocationID.x;
  if (local < 4u) {
    group_low[local] = 0xffffffffu;
    group_high[local] = 0u;
  }
  barrier();
  uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint i = gl_GlobalInvocationID.x; i < count; i += stride) {
    vec4 point = points[first_point + i];
    for (int k = 0; k < 4; ++k) {
      if (isnan(point[k]) || isinf(point[k])) continue;
      atomicMin(group_low[k], ordered(point[k]));
      atomicMax(group_high[k], ordered(point[k]));
    }
  }
  barrier();
  if (local < 4u) {
    atomicMin(low[local], group_low[local]);
    atomicMax(high[local], group_high[local]);
  }
}
