// Yield and return of each particle; see kernels/plastic_return.decl.
#include "common/bonds.glsl"

// e = y / x - 1 of a bond, x its length at rest.
float strain_of(uint entry, vec3 y) {
  float x = length(unpack_bond(bond[entry + 16], unit)) * rest[entry];
  return (length(y) - x) / x;
}

void main() {
  uint local = thread_index();
  if (local >= threads) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  vec4 surface = yield[2 * i], so_far = flow[2 * i];
  float volume = yield[2 * i + 1].x, inverse_modulus = yield[2 * i + 1].y, a_over_b = yield[2 * i + 1].z;
  float isotropic = 0.0, square = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    if (j == i) continue;
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    isotropic += weight[entry] * dot(xi, xi) * strain_of(entry, y);
  }
  isotropic *= inverse_modulus;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    if (j == i) continue;
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    float deviatoric = strain_of(entry, y) - isotropic;
    square += weight[entry] * dot(xi, xi) * deviatoric * deviatoric;
  }
  square *= inverse_modulus;
  float spread = sqrt(square), bears = surface.z + surface.w * so_far.x - surface.y * isotropic;
  float alpha = 0.0, beta = 0.0, strain = 0.0, taken = 0.0;
  bool flows = surface.x * spread > bears;
  if (flows) {
    float most = equivalent * spread; // equivalent plastic strain that leaves nothing deviatoric
    strain = (surface.x * spread - bears) / (surface.x / equivalent + surface.w);
    if (strain < most) {
      beta = strain / most;
    } else {
      strain = most;
      beta = 1.0;
      float beyond = surface.y * isotropic - (surface.z + surface.w * (so_far.x + most));
      if (beyond > 0.0) alpha = min(beyond / (surface.y * isotropic), 1.0);
    }
    taken = (beta * (1.0 - beta) * square + a_over_b * alpha * (1.0 - alpha) * isotropic * isotropic) /
            inverse_modulus; // the stress that stays, times the strain that flows
  }
  flow[2 * i] = vec4(so_far.x + strain, so_far.y + taken,
                     so_far.z + volume * dimension * alpha * isotropic, flows ? 1.0 : 0.0);
  flow[2 * i + 1] = vec4(isotropic, 1.0 - alpha, 1.0 - beta, max(a_over_b, 1.0));
}
