// Sums a vector over a group of 128 in a fixed order; every lane gets the sum.
shared vec4 group_vector[128];

vec4 sum_over_group(vec4 value) {
  uint lane = gl_LocalInvocationIndex;
  barrier();
  group_vector[lane] = value;
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_vector[lane] += group_vector[lane + half_width];
    barrier();
  }
  return group_vector[0];
}
