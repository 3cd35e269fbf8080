// See kernels/factor_up.decl.
#include "common/solver.glsl"

void main() {
  uint t = thread_index();
  if (t >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uvec4 block = factor_block[first_block + t / 16u];
  uint lane = t % 16u, at = 16u * block.x + lane;
  vec3 sum = vec3(0.0);
  for (uint k = 0u; k < block.z; ++k) {
    uvec4 source = factor_slot[block.y + k];
    vec3 b = residual[source.x].xyz + (front[source.y].xyz + front[source.z].xyz);
    sum += factor[at + 16u * k] * b;
  }
  uint own = block.y + block.w + lane;
  uvec4 slot = factor_slot[own];
  if (slot.w == 0u) sum += front[slot.y].xyz + front[slot.z].xyz;
  front[own] = vec4(sum, 0.0);
}
