// A layer is born; see kernels/fluid_emit.decl.

void main() {
  uint k = thread_index();
  if (k >= threads) return;
  vec4 point = emitter_point[first + k];
  uint i = emitter_slot[k];
  position[i] = vec4(point.xyz + vec3(flown_x, flown_y, flown_z), point.w);
  velocity[i] = vec4(speed_x, speed_y, speed_z, held);
  if (k == 0u) emitter_count[2u * emitter] += threads;
}
