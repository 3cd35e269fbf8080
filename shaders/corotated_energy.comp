// Energy of law M4 at each particle; see kernels/corotated_energy.decl.
#include "common/bonds.glsl"
#include "common/rotation.glsl"

void main() {
#if gated
  if (gate[0].x > 0.0) return; // SOLVER_STOP
#endif
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  mat3 r = rotation_matrix(rotation[i]);
  float deviation = 0.0, dilatation = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    vec3 target = r * unpack_bond(bond[entry + 16], unit);
    vec3 off = y - target;
    deviation += weight[entry] * dot(off, off);
    dilatation += weight[entry] * dot(off, target);
  }
  float inverse_modulus = shape[i];
  dilatation *= inverse_modulus; // theta - 1
  float volumetric = inverse_modulus > 0.0 ? shape[stride + i] * dilatation * dilatation / inverse_modulus : 0.0;
  energy[i] = 0.5 * (deviation + volumetric);
}
