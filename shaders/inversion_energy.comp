// Energy against inversion; see kernels/inversion_energy.decl.
#include "common/bonds.glsl"
#include "common/cofactor.glsl"
#include "common/rotation.glsl"

void main() {
#if gated
  if (gate[0].x > 0.0) return; // SOLVER_STOP
#endif
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  float push = inversion_shape[stride + i];
  if (!(push > 0.0)) return;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  mat3 s = mat3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    s += outerProduct(weight[entry] * y, unpack_bond(bond[entry + 16], unit));
  }
  float inverse_modulus = inversion_shape[i];
  mat3 f = (inverse_modulus * s) * symmetric(inversion_shape[3 * stride + i], inversion_shape[4 * stride + i],
                                             inversion_shape[5 * stride + i], inversion_shape[6 * stride + i],
                                             inversion_shape[7 * stride + i], inversion_shape[8 * stride + i]);
  mat3 off = f - clamp_singular_values(f, 0.1);
  energy[i] += 0.5 * push / inverse_modulus * inner(off, off);
}
