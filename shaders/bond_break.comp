// Bonds that are too long; see kernels/bond_break.decl.
#include "common/bonds.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  vec2 own = toughness[i].xy;
  float lost = 0.0;
  bool changed = false;
  float share = 0.0, stiffness = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    if (j == i) continue;
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    vec2 other = toughness[j].xy;
    float x2 = dot(xi, xi);
    float c_out = weight[entry], c_in = weight[entry + 16];
    if (dot(y, y) > x2 * min(own.x, other.x)) {
      changed = true;
      if (c_out + c_in > 0.0) lost += 1.0;
      bond[entry] = i;
      bond[entry + 16] = 0u;
      weight[entry] = 0.0;
      weight[entry + 16] = 0.0;
    } else {
      share += c_out * x2;
      stiffness += own.y * c_out + other.y * c_in;
    }
  }
  if (!changed) return;
  shape[share_row * stride + i] = shape[i] * share;
  shape[(share_row + 1) * stride + i] += lost;
  linear_start[i].w = stiffness;
}
