// Local step of law M3; see kernels/stretch_state.decl.
#include "common/bonds.glsl"
#include "common/basis.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || gate[0].x > 0.0) return; // SOLVER_STOP
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  float place = shape[2 * stride + i];
  uint row0 = uint(place);
  bool squared = energies[row0].x > 0.0;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  float lengthening = 0.0; // the mean stretch less one, or half the mean square less one, without cancellation
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    float x = length(unpack_bond(bond[entry + 16], unit)), size = length(y);
    lengthening += weight[entry] * (size - x) * (squared ? 0.5 * (size + x) : x);
  }
  float e = shape[i] * lengthening; // theta - 1
  if (squared) e = 2.0 * e / (1.0 + sqrt(max(1.0 + 2.0 * e, 0.0)));
  float phi = 0.5 * basis_slopes(row0 + STRETCH_VOLUME, e).x;
  if (squared) phi /= max(1.0 + e, 1e-6);
  stretch_record[2 * i] = vec4(ui, phi);
  stretch_record[2 * i + 1] = vec4(yi, place);
#if potential
  energy[i] = shape[i] > 0.0 ? 0.5 * basis_value(row0 + STRETCH_VOLUME, e) / shape[i] : 0.0;
#endif
}
