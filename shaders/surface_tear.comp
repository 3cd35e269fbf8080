// A triangle whose particles have lost each other; see kernels/surface_tear.decl.
#include "common/bonds.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads) return;
  uint t = first_triangle + local;
  uvec4 corners = skin_triangle[t];
  uint particle[12], linked[12];
  uint count = 0;
  for (int c = 0; c < 3; ++c) {
    uvec4 nearest = skin_particle[corners[c]];
    for (int k = 0; k < 4; ++k) {
      uint p = 0;
      while (p < count && particle[p] != nearest[k]) ++p;
      if (p == count) particle[count++] = nearest[k];
    }
  }
  for (uint p = 0; p < count; ++p) {
    uint i = particle[p] - first, slice = first_slice + i / SLICE, lane = i % SLICE;
    linked[p] = 1u << p;
    for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
      uint j = bond[32 * row + lane];
      for (uint q = 0; q < count; ++q)
        if (particle[q] == j) linked[p] |= 1u << q;
    }
  }
  uint left = (1u << count) - 1u, pieces = 0u;
  while (left != 0u) { // the piece of the first that is left
    uint piece = left & (~left + 1u), before = 0u;
    while (piece != before) {
      before = piece;
      for (uint p = 0; p < count; ++p)
        if ((piece >> p & 1u) != 0u) piece |= linked[p];
    }
    left &= ~piece;
    ++pieces;
  }
  torn[t] = pieces > corners.w ? 1u : 0u;
}
