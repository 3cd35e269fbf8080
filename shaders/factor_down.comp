// See kernels/factor_down.decl.
#include "common/solver.glsl"

void main() {
  uint t = thread_index();
  if (t >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uvec4 block = factor_block[first_block + t / 16u];
  uint lane = t % 16u, at = 16u * block.x + lane;
  uvec4 own = factor_slot[block.y + block.w + lane];
  if (own.w == 0u) return; // beyond the last column
  vec3 sum = vec3(0.0);
  for (uint k = block.w; k < block.z; ++k) {
    uvec4 slot = factor_slot[block.y + k];
    vec3 value = slot.w != 0u ? front[block.y + k].xyz : preconditioned[slot.x].xyz;
    sum += factor[at + 16u * (k - block.w)] * value;
  }
  preconditioned[own.x] = vec4(sum, 0.0);
}
