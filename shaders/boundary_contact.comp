// Obstacles; see kernels/boundary_contact.decl.
#include "common/contact.glsl"
#include "common/obstacle.glsl"
#include "common/solver.glsl"

#if meshes
#include "common/obstacle_grid.glsl"
#endif

void main() {
  uint i = thread_index();
  if (i >= threads || solver[SOLVER_STOP] > 0.0) return;
  vec4 f = force[i];
  vec3 u = displacement[i].xyz, base = vec3(base_x, base_y, base_z);
#if potential || tangent
  vec4 begin = start[i];
#else
  vec4 begin = vec4((origin[owner[i]].xyz - base) + position[i].xyz, f.w > 0.0 ? f.w : least_stiffness);
#endif
  float k = begin.w;
#if potential
  float stored = 0.0;
#endif
#if tangent
  vec3 diagonal = vec3(0.0), mixed = vec3(0.0); // xx yy zz | xy xz yz
#endif
  uint acts = 0u;
  for (uint o = 0u; o < obstacles && !(f.w < 0.0); ++o) {
    uint row = OBSTACLE_ROWS * o;
    vec4 traits = obstacle[row + OBSTACLE_KIND], place = obstacle[row + OBSTACLE_CENTRE];
    vec3 from = begin.xyz - (place.xyz - base), now = from + u;
    if (dot(now, now) > place.w * place.w) continue;
    vec4 size = obstacle[row + OBSTACLE_SIZE];
    vec4 r0 = obstacle[row + OBSTACLE_AXES], r1 = obstacle[row + OBSTACLE_AXES + 1],
         r2 = obstacle[row + OBSTACLE_AXES + 2];
    vec3 a = from.x * r0.xyz + from.y * r1.xyz + from.z * r2.xyz; // R^T from
    vec3 v = u.x * r0.xyz + u.y * r1.xyz + u.z * r2.xyz;
    int kind = int(traits.x);
    float d;
    vec3 normal;
    if (kind == OBSTACLE_PLANE) {
      d = a.y + v.y;
      normal = vec3(0.0, 1.0, 0.0);
    } else if (kind == OBSTACLE_SPHERE) {
      d = sphere_distance(a, v, size.x, normal);
    } else if (kind == OBSTACLE_BOX) {
      d = box_distance(a, v, size.xyz, normal);
    } else if (kind == OBSTACLE_CYLINDER) {
      d = cylinder_distance(a, v, size.x, size.y, normal);
    } else if (kind == OBSTACLE_TORUS) {
      d = torus_distance(a, v, size.x, size.y, normal);
    } else {
#if meshes
      d = mesh_distance(a, v, vec3(r0.w, r1.w, r2.w), size.w, grid[o], traits.w > 0.0, normal);
#else
      continue;
#endif
    }
    float sense = traits.w > 0.0 ? -1.0 : 1.0;
    float depth = radius - sense * d;
    if (!(depth > 0.0)) continue;
    vec3 gradient = sense * vec3(dot(r0.xyz, normal), dot(r1.xyz, normal), dot(r2.xyz, normal));
    vec3 push = k * depth * gradient;
    vec4 s0 = obstacle[row + OBSTACLE_SHIFT], s1 = obstacle[row + OBSTACLE_SHIFT + 1],
         s2 = obstacle[row + OBSTACLE_SHIFT + 2];
    vec3 slide = u - vec3(dot(s0.xyz, now) + s0.w, dot(s1.xyz, now) + s1.w, dot(s2.xyz, now) + s2.w);
    float steep2 = dot(gradient, gradient);
    if (steep2 > 0.0) slide -= (dot(gradient, slide) / steep2) * gradient;
    float hold = k;
    if (traits.z == 0.0) {
      float limit = traits.y * length(push), distance_slid = length(slide);
      if (!(k * distance_slid < limit)) hold = distance_slid > 0.0 ? limit / distance_slid : 0.0; // without friction: none
    }
    f.xyz += push - hold * slide;
    f.w += k;
#if potential
    stored += 0.5 * k * depth * depth;
    if (traits.z != 0.0) stored += 0.5 * k * dot(slide, slide);
#endif
#if tangent
    vec3 g = gradient;
    float across = k - (steep2 > 0.0 ? hold / steep2 : 0.0);
    diagonal += hold + across * g * g;
    mixed += across * vec3(g.x * g.y, g.x * g.z, g.y * g.z);
#endif
    acts = 1u;
  }
  force[i] = f;
  touched[i] = acts;
#if potential
  if (acts != 0u) energy[i] += stored;
#endif
#if tangent
  contact_block[2 * i] = vec4(diagonal.x, mixed.x, mixed.y, diagonal.y);
  contact_block[2 * i + 1] = vec4(mixed.z, diagonal.z, 0.0, 0.0);
#endif
}
