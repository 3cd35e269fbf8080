// Signed distances of meshes, from the buffer `grid_distance`.
// Trilinear in the cell that a + u lies in; the normal is its exact gradient, of length about one. Beyond the grid a
// container's wall goes on from the grid's edge, and an obstacle is far.
float grid_value(uvec4 nodes, uvec3 at) { return grid_distance[nodes.w + (at.z * nodes.y + at.y) * nodes.x + at.x]; }

float mesh_distance(vec3 a, vec3 u, vec3 low, float cell, uvec4 nodes, bool container, out vec3 normal) {
  vec3 cell_at = (a - low) / cell, whole = floor(cell_at);
  vec3 part = (cell_at - whole) + u / cell; // relative to `whole`: u keeps its digits
  vec3 last = vec3(nodes.xyz) - 2.0;
  vec3 at = clamp(whole + floor(part), vec3(0.0), last);
  part -= at - whole;
  vec3 within = clamp(part, vec3(0.0), vec3(1.0)), beyond = cell * (part - within);
  float away = length(beyond);
  normal = vec3(0.0);
  if (!(away < 1e18) || (away > 0.0 && !container)) return 1e18;
  uvec3 n = uvec3(at);
  float v000 = grid_value(nodes, n), v100 = grid_value(nodes, n + uvec3(1, 0, 0));
  float v010 = grid_value(nodes, n + uvec3(0, 1, 0)), v110 = grid_value(nodes, n + uvec3(1, 1, 0));
  float v001 = grid_value(nodes, n + uvec3(0, 0, 1)), v101 = grid_value(nodes, n + uvec3(1, 0, 1));
  float v011 = grid_value(nodes, n + uvec3(0, 1, 1)), v111 = grid_value(nodes, n + uvec3(1, 1, 1));
  float x00 = v000 + within.x * (v100 - v000), x10 = v010 + within.x * (v110 - v010);
  float x01 = v001 + within.x * (v101 - v001), x11 = v011 + within.x * (v111 - v011);
  float y0 = x00 + within.y * (x10 - x00), y1 = x01 + within.y * (x11 - x01);
  float value = y0 + within.z * (y1 - y0);
  if (away > 0.0) {
    normal = beyond / away;
    return value + away;
  }
  float dx0 = (v100 - v000) + within.y * ((v110 - v010) - (v100 - v000));
  float dx1 = (v101 - v001) + within.y * ((v111 - v011) - (v101 - v001));
  normal = vec3(dx0 + within.z * (dx1 - dx0), (x10 - x00) + within.z * ((x11 - x01) - (x10 - x00)), y1 - y0) / cell;
  return value;
}
