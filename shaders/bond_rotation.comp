// See kernels/bond_rotation.decl.
#include "common/bonds.glsl"
#include "common/rotation.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_TAKEN] == 0.0 || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  mat3 s = mat3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane, j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    s += outerProduct(weight[entry] * y, unpack_bond(bond[entry + 16], unit));
  }
  rotation[i] = polar_rotation(shape[i] * s, rotation[i]);
}
