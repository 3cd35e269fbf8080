// Energy of law M5, neo-Hookean, at each particle; see kernels/correspondence_energy.decl.
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
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  mat3 r = rotation_matrix(rotation[i]), d = mat3(0.0);
  float deviation = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    vec3 off = y - r * xi;
    deviation += weight[entry] * dot(off, off);
    d += outerProduct(weight[entry] * off, xi);
  }
  float inverse_modulus = shape[i];
  mat3 excess = (inverse_modulus * d) * // F - R
                symmetric(shape[11 * stride + i], shape[12 * stride + i], shape[13 * stride + i],
                          shape[14 * stride + i], shape[15 * stride + i], shape[16 * stride + i]);
  mat3 h = transpose(r) * excess;
  float trace = h[0][0] + h[1][1] + h[2][2];
  float pairs = (h[0][0] * h[1][1] - h[1][0] * h[0][1]) + (h[0][0] * h[2][2] - h[2][0] * h[0][2]) +
                (h[1][1] * h[2][2] - h[2][1] * h[1][2]);
  float volume = determinant(h), growth = trace + pairs + volume; // J - 1
  float affine = 0.5 * inner(h, h) - pairs - volume + 0.5 * (1.0 + shape[stride + i] / 1.5) * growth * growth;
  affine = inverse_modulus > 0.0 ? affine / (3.0 * inverse_modulus) : 0.0;
  energy[i] = affine + 0.5 * (deviation - inner(excess, d)); // the rest is what no gradient explains
}
