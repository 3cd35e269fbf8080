// See kernels/stretch_product.decl.
#include "common/bonds.glsl"
#include "common/direction.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = tangent[4 * i].xyz, pi = direction[i].xyz;
  vec4 kept = tangent[4 * i + 1];
  bool squared = energies[uint(kept.x)].x > 0.0;
  float lengthening = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = tangent[4 * j].xyz - yi, xi = unpack_bond(bond[entry + 16], unit);
    float lever = squared ? length(y) : length(xi);
    lengthening += weight[entry] * lever * dot(bond_direction(y, xi), direction[j].xyz - pi);
  }
  stretch_record[2 * i] = vec4(pi, kept.y * lengthening);
}
