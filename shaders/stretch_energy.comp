// Energy of law M3 at each particle; see kernels/stretch_energy.decl.
#include "common/bonds.glsl"
#include "common/basis.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  uint row0 = uint(shape[2 * stride + i]);
  bool squared = energies[row0].x > 0.0;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  float stretching = 0.0, lengthening = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    float x = length(unpack_bond(bond[entry + 16], unit)), per_x = x > 0.0 ? 1.0 / x : 0.0, size = length(y);
    float h = basis_value(row0 + STRETCH_BOND, (size - x) * per_x);
#if anisotropic
    h *= strength[entry];
#endif
    stretching += weight[entry] * x * x * h;
    lengthening += weight[entry] * (size - x) * (squared ? 0.5 * (size + x) : x);
  }
  float inverse_modulus = shape[i], e = inverse_modulus * lengthening;
  if (squared) e = 2.0 * e / (1.0 + sqrt(max(1.0 + 2.0 * e, 0.0)));
  float volumetric = inverse_modulus > 0.0 ? basis_value(row0 + STRETCH_VOLUME, e) / inverse_modulus : 0.0;
  energy[i] = 0.5 * (stretching + volumetric);
}
