// Signed distances of obstacles in their own axes, at a + u with a fixed during a solve. What depends on u alone is
// added as a difference, so that rounding of the large a does not disturb the small u. Normals point to the free side.

// |a + u| - |a|
float length_change(float length_a, float length_b, float slope) {
  float sum = length_a + length_b;
  return sum > 0.0 ? slope / sum : 0.0;
}

float sphere_distance(vec3 a, vec3 u, float size, out vec3 normal) {
  float length_a = length(a), length_b = length(a + u);
  normal = length_b > 0.0 ? (a + u) / length_b : vec3(0.0, 1.0, 0.0);
  return (length_a - size) + length_change(length_a, length_b, dot(2.0 * a + u, u));
}

float box_distance(vec3 a, vec3 u, vec3 half_size, out vec3 normal) {
  vec3 b = a + u;
  vec3 side = vec3(b.x < 0.0 ? -1.0 : 1.0, b.y < 0.0 ? -1.0 : 1.0, b.z < 0.0 ? -1.0 : 1.0);
  vec3 q = (side * a - half_size) + side * u;
  float most = max(q.x, max(q.y, q.z));
  if (most > 0.0) {
    vec3 beyond = max(q, vec3(0.0));
    float away = length(beyond);
    normal = side * beyond / away;
    return away;
  }
  normal = q.x == most ? vec3(side.x, 0.0, 0.0) : q.y == most ? vec3(0.0, side.y, 0.0) : vec3(0.0, 0.0, side.z);
  return most;
}

// Away from the y axis: distance minus `size` (returned) and direction.
float radial_distance(vec3 a, vec3 u, float size, out vec3 direction) {
  vec2 a2 = a.xz, u2 = u.xz;
  float length_a = length(a2), length_b = length(a2 + u2);
  direction = length_b > 0.0 ? vec3(a2.x + u2.x, 0.0, a2.y + u2.y) / length_b : vec3(1.0, 0.0, 0.0);
  return (length_a - size) + length_change(length_a, length_b, dot(2.0 * a2 + u2, u2));
}

float cylinder_distance(vec3 a, vec3 u, float size, float half_height, out vec3 normal) {
  vec3 outward;
  float side = a.y + u.y < 0.0 ? -1.0 : 1.0;
  float q = radial_distance(a, u, size, outward), r = (side * a.y - half_height) + side * u.y;
  if (max(q, r) > 0.0) {
    float away = length(max(vec2(q, r), vec2(0.0)));
    normal = (max(q, 0.0) * outward + vec3(0.0, side * max(r, 0.0), 0.0)) / away;
    return away;
  }
  normal = q >= r ? outward : vec3(0.0, side, 0.0);
  return max(q, r);
}

float torus_distance(vec3 a, vec3 u, float ring, float tube, out vec3 normal) {
  vec3 outward;
  float reach = length(a.xz) - ring, q = radial_distance(a, u, ring, outward), change = q - reach;
  float length_a = length(vec2(reach, a.y)), length_b = length(vec2(q, a.y + u.y));
  normal = length_b > 0.0 ? (q * outward + vec3(0.0, a.y + u.y, 0.0)) / length_b : vec3(0.0, 1.0, 0.0);
  float slope = (2.0 * reach + change) * change + (2.0 * a.y + u.y) * u.y;
  return (length_a - tube) + length_change(length_a, length_b, slope);
}
