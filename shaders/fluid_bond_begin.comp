// Start of the elastic solve of bonded fluids; see kernels/fluid_bond_begin.decl.
#include "common/fluid.glsl"
#include "common/fluid_bond.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  float mass = fluid_place[i].w;
  vec4 v = fluid_velocity[i], u = vec4(0.0);
  uvec4 was = fluid_was[i];
  bool moves = mass > 0.0, bonds = mass != 0.0 && was.y != 0u && was.y != FAMILY_GHOST;
  if (moves || bonds) u.xyz = time_step * v.xyz;
  float k = bonds ? fluid_elastic[ELASTIC_ROWS * uint(v.w) + ELASTIC_BONDS].x : 0.0;
  fluid_target[i] = vec4(u.xyz, moves ? mass / (time_step * time_step) : -1.0);
  fluid_displacement[i] = u;
  fluid_stay[i] = vec4(moves || bonds ? 1.0 : 0.0, 0.0, k, bonds ? v.w : 0.0);
#if plastic
  fluid_flow[2u * i] = bonds ? vec4(fluid_flow_earlier[2u * was.x].xyz, 0.0) : vec4(0.0);
  fluid_flow[2u * i + 1u] = vec4(0.0, 1.0, 1.0, 0.0);
#endif
}
