// Energy of law M2 at each particle; see kernels/ordinary_energy.decl.
#include "common/bonds.glsl"

void main() {
#if gated
  if (gate[0].x > 0.0) return; // SOLVER_STOP
#endif
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  float stretching = 0.0, dilatation = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    float x = length(unpack_bond(bond[entry + 16], unit)), stretch = length(y) - x;
    stretching += weight[entry] * stretch * stretch;
    dilatation += weight[entry] * x * stretch;
  }
  float inverse_modulus = shape[i];
  dilatation *= inverse_modulus; // theta - 1
  float volumetric = inverse_modulus > 0.0 ? shape[stride + i] * dilatation * dilatation / inverse_modulus : 0.0;
  energy[i] = 0.5 * (stretching + volumetric);
}
