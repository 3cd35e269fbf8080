// Local step of law M2; see kernels/ordinary_state.decl.
#include "common/bonds.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_STOP] > 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  float lengthening = 0.0; // sum c x (y - x): the dilatation less one, without its cancellation
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    float x = length(unpack_bond(bond[entry + 16], unit));
    lengthening += weight[entry] * x * (length(y) - x);
  }
  float phi = shape[stride + i] * shape[i] * lengthening;
  extension[i] = vec4(ui, phi);
}
