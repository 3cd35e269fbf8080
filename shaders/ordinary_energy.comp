// Energy of law M2 at each particle; see kernels/ordinary_energy.decl.
#include "common/bonds.glsl"
#include "common/rest.glsl"

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
    vec4 at_rest = bond_at_rest(entry);
    float x = length(unpack_bond(bond[entry + 16], unit)) * at_rest.z, stretch = length(y) - x;
    stretching += at_rest.x * stretch * stretch;
    dilatation += at_rest.x * x * stretch;
  }
  float inverse_modulus = shape[i];
  dilatation *= inverse_modulus; // theta - 1
  float volumetric = inverse_modulus > 0.0 ? shape[stride + i] * dilatation * dilatation / inverse_modulus : 0.0;
  energy[i] = 0.5 * (stretching + volumetric);
}
