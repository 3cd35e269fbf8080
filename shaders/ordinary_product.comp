// See kernels/ordinary_product.decl.
#include "common/bonds.glsl"
#include "common/direction.glsl"
#include "common/rest.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
#if plastic
  bool wanted = gate[3].y != 0.0; // SOLVER_LINEAR
#else
  bool wanted = solver[SOLVER_LINEAR] != 0.0;
#endif
  if (local >= threads || !wanted) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 yi = tangent[4 * i].xyz, pi = direction[i].xyz;
  float lengthening = 0.0;
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec3 xi = unpack_bond(bond[entry + 16], unit);
    vec4 at_rest = bond_at_rest(entry);
    lengthening += at_rest.x * (length(xi) * at_rest.z) *
                   dot(bond_direction(tangent[4 * j].xyz - yi, xi), direction[j].xyz - pi);
  }
  extension[i] = vec4(pi, shape[stride + i] * shape[i] * lengthening);
}
