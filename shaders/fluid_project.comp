// Out of obstacles; see kernels/fluid_project.decl.
#include "common/contact.glsl"
#include "common/obstacle.glsl"
#if meshes
#include "common/obstacle_grid.glsl"
#endif

// Share of the cubic spline beyond a plane at x supports, in three dimensions (in two it differs by 3 %), and its slope.
float beyond(float x) {
  float a = max(1.0 - x, 0.0), b = max(1.0 - 2.0 * x, 0.0), a5 = a * a * a * a * a, b5 = b * b * b * b * b;
  return a5 * (1.6 - 16.0 / 15.0 * a) - b5 * (0.1 - b / 15.0);
}
float beyond_slope(float x) {
  float a = max(1.0 - x, 0.0), b = max(1.0 - 2.0 * x, 0.0), a4 = a * a * a * a, b4 = b * b * b * b;
  return b4 * (1.0 - 0.8 * b) - a4 * (8.0 - 6.4 * a);
}

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 end = fluid_place[i], wall = vec4(0.0);
  if (!(end.w > 0.0)) {
    fluid_wall[i] = wall;
    return;
  }
  vec3 start = fluid_start[i].xyz;
#if spread
  vec3 moved = end.xyz - start;
#else
  vec3 moved = fluid_moved[i].xyz;
#endif
  for (uint o = 0u; o < obstacles; ++o) {
    uint row = OBSTACLE_ROWS * o;
    vec4 traits = obstacle[row + OBSTACLE_KIND], place = obstacle[row + OBSTACLE_CENTRE];
    vec3 began = start - place.xyz, from = began + moved;
    if (!(dot(from, from) <= place.w * place.w)) continue;
    vec4 size = obstacle[row + OBSTACLE_SIZE];
    vec4 r0 = obstacle[row + OBSTACLE_AXES], r1 = obstacle[row + OBSTACLE_AXES + 1],
         r2 = obstacle[row + OBSTACLE_AXES + 2];
    vec3 a = began.x * r0.xyz + began.y * r1.xyz + began.z * r2.xyz; // R^T began
    vec3 u = moved.x * r0.xyz + moved.y * r1.xyz + moved.z * r2.xyz;
    int kind = int(traits.x);
    float d;
    vec3 normal;
    if (kind == OBSTACLE_PLANE) {
      d = a.y + u.y;
      normal = vec3(0.0, 1.0, 0.0);
    } else if (kind == OBSTACLE_SPHERE) {
      d = sphere_distance(a, u, size.x, normal);
    } else if (kind == OBSTACLE_BOX) {
      d = box_distance(a, u, size.xyz, normal);
    } else if (kind == OBSTACLE_CYLINDER) {
      d = cylinder_distance(a, u, size.x, size.y, normal);
    } else if (kind == OBSTACLE_TORUS) {
      d = torus_distance(a, u, size.x, size.y, normal);
    } else {
#if meshes
      d = mesh_distance(a, u, vec3(r0.w, r1.w, r2.w), size.w, grid[o], traits.w > 0.0, normal);
#else
      continue;
#endif
    }
    float sense = traits.w > 0.0 ? -1.0 : 1.0;
    float away = sense * d, depth = radius - away;
    if (!(away < support)) continue;
    vec3 gradient = sense * vec3(dot(r0.xyz, normal), dot(r1.xyz, normal), dot(r2.xyz, normal));
    float steep2 = dot(gradient, gradient);
    if (!(steep2 > 0.0)) continue;
    float x = max(away, radius) / support;
    if (traits.z != float(OBSTACLE_GHOSTS)) wall += share * vec4(beyond_slope(x) / (support * sqrt(steep2)) * gradient, beyond(x));
    if (!(depth > 0.0)) continue;
    vec4 s0 = obstacle[row + OBSTACLE_SHIFT], s1 = obstacle[row + OBSTACLE_SHIFT + 1],
         s2 = obstacle[row + OBSTACLE_SHIFT + 2];
    vec3 push = depth / steep2 * gradient;
    vec3 slide = moved - vec3(dot(s0.xyz, from) + s0.w, dot(s1.xyz, from) + s1.w, dot(s2.xyz, from) + s2.w);
    slide -= dot(gradient, slide) / steep2 * gradient;
    float slid = length(slide), held = traits.z == float(OBSTACLE_STICKS) ? slid : min(slid, traits.y * length(push));
    if (held > 0.0) push -= held / slid * slide;
    moved += push;
  }
  fluid_moved[i].xyz = moved;
  fluid_place[i] = vec4(start + moved, end.w);
  fluid_wall[i] = wall;
}
