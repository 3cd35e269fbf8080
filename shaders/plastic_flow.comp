// Rest lengths after the return; see kernels/plastic_flow.decl.
#include "common/bonds.glsl"

// Of an end whose particle lets these shares of its strain stay. Both particles of a bond compute both ends: no rounding
// may depend on whose row it is.
float rest_after(float before, float x, float size, vec4 stays) {
  if (stays.y >= 1.0 && stays.z >= 1.0) return before;
  precise float now = x * before;
  precise float strain = (size - now) / now;
  precise float stretch = 1.0 + (stays.y * stays.x + stays.z * (strain - stays.x));
  precise float after = size / (x * max(stretch, 0.05));
  return clamp(after, 0.05, 20.0);
}

void main() {
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  vec4 own = flow[2 * i + 1];
  float stiffness = 0.0;
  bool changed = false;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    if (j == i) continue;
    precise vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    precise float x = length(unpack_bond(bond[entry + 16], unit)), size = length(y);
    vec4 other = flow[2 * j + 1];
    float before_out = rest[entry], before_in = rest[entry + 16];
    float p_out = rest_after(before_out, x, size, own), p_in = rest_after(before_in, x, size, other);
    stiffness += own.w * weight[entry] / (p_out * p_out) + other.w * weight[entry + 16] / (p_in * p_in);
    if (p_out == before_out && p_in == before_in) continue;
    changed = true;
    rest[entry] = p_out;
    rest[entry + 16] = p_in;
  }
  if (changed) linear_start[i].w = stiffness;
}
