// Local step of law M2; see kernels/ordinary_state.decl.
#include "common/bonds.glsl"
#include "common/rest.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
#if plastic
  bool stopped = gate[0].x > 0.0; // SOLVER_STOP
#else
  bool stopped = solver[SOLVER_STOP] > 0.0;
#endif
  if (local >= threads || stopped) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = position[i].xyz, ui = displacement[i].xyz;
  float lengthening = 0.0; // sum c x (y - x): the dilatation less one, without its cancellation
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 y = (position[j].xyz - yi) + (displacement[j].xyz - ui);
    vec4 at_rest = bond_at_rest(entry);
    float x = length(unpack_bond(bond[entry + 16], unit)) * at_rest.z;
    lengthening += at_rest.x * x * (length(y) - x);
  }
  float phi = shape[stride + i] * shape[i] * lengthening;
  extension[i] = vec4(ui, phi);
}
