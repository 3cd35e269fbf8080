// See kernels/ordinary_product_force.decl.
#include "common/bonds.glsl"
#include "common/direction.glsl"
#include "common/rest.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec4 yi = tangent[4 * i], pi = extension[i];
  vec3 sum = vec3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    uint j = bond[entry];
    vec4 yj = tangent[4 * j], pj = extension[j];
    vec3 xi = unpack_bond(bond[entry + 16], unit), y = yj.xyz - yi.xyz, dy = pj.xyz - pi.xyz;
    vec4 at_rest = bond_at_rest(entry);
    float x = length(xi), size = length(y), c_out = at_rest.x, c_in = at_rest.y;
    float x_out = x * at_rest.z, x_in = x * at_rest.w;
    vec3 n = bond_direction(y, xi);
    float along = dot(n, dy), pull = c_out * (size - x_out + x_out * yi.w) + c_in * (size - x_in + x_in * yj.w);
    sum += ((c_out + c_in) * along + x * (c_out * at_rest.z * pi.w + c_in * at_rest.w * pj.w)) * n +
           (pull / max(size, 1e-3 * x + 1e-30)) * (dy - along * n);
  }
  force[i] = vec4(sum, 0.0);
}
