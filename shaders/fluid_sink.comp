// What has run into a sink is taken out; see kernels/fluid_sink.decl.
#include "common/contact.glsl"
#include "common/fluid.glsl"
#include "common/obstacle.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec4 y = position[i];
  if (y.w == 0.0) return;
  vec3 place = (origin[fluid_kind[i] & FLUID_BODY].xyz - vec3(base_x, base_y, base_z)) + y.xyz;
  for (uint s = 0u; s < sinks; ++s) {
    uint row = OBSTACLE_ROWS * s;
    vec3 from = place - sink[row + OBSTACLE_CENTRE].xyz, none = vec3(0.0), normal;
    vec4 size = sink[row + OBSTACLE_SIZE];
    vec3 a = from.x * sink[row + OBSTACLE_AXES].xyz + from.y * sink[row + OBSTACLE_AXES + 1].xyz +
             from.z * sink[row + OBSTACLE_AXES + 2].xyz; // R^T from
    int kind = int(sink[row + OBSTACLE_KIND].x);
    float d = a.y;
    if (kind == OBSTACLE_SPHERE) d = sphere_distance(a, none, size.x, normal);
    if (kind == OBSTACLE_BOX) d = box_distance(a, none, size.xyz, normal);
    if (kind == OBSTACLE_CYLINDER) d = cylinder_distance(a, none, size.x, size.y, normal);
    if (kind == OBSTACLE_TORUS) d = torus_distance(a, none, size.x, size.y, normal);
    if (!(d < 0.0)) continue;
    position[i].w = 0.0;
    velocity[i] = vec4(0.0);
    atomicAdd(sunk[s], 1u);
    return;
  }
}
