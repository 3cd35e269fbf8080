// Ghosts in sorted order; see kernels/fluid_ghost_gather.decl.
void main() {
  uint place = thread_index();
  if (place >= threads || place >= particle_count + ghost_count) return;
  uint i = fluid_particle[place];
  if (i < particle_count) return;
  vec4 at = ghost_place[i - particle_count];
  if (at.w == 0.0) return;
  fluid_place[place] = at;
  fluid_velocity[place] = ghost_velocity[i - particle_count];
  fluid_start[place] = vec4(at.xyz, 0.0);
}
