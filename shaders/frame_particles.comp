// Positions in the world; see kernels/frame_particles.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  vec3 world = vec3(scene_x, scene_y, scene_z) + origin[owner[i]].xyz + position[i].xyz;
  float value = 0.0;
#if field == 1
  value = length(velocity[i].xyz);
#elif field == 2
  value = gradient[3 * i].w;
#elif field == 3
  value = energy[i] / start[i].w;
#elif field == 4
  value = distance(world, start[i].xyz);
#elif field == 5
  value = 1.0 - shape[share_at + i];
#elif field == 6
  value = flow[2 * i].x;
#endif
#if gone
  if (position[i].w == 0.0) {
    particle[i] = vec4(uintBitsToFloat(0x7f800000u));
    return;
  }
#endif
  particle[i] = vec4(world, value);
}
