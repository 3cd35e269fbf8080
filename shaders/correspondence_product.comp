// See kernels/correspondence_product.decl.
#include "common/bonds.glsl"
#include "common/cofactor.glsl"
#include "common/solver.glsl"

void main() {
  uint local = thread_index();
  if (local >= threads || solver[SOLVER_LINEAR] == 0.0) return;
  uint i = first + local, slice = first_slice + local / SLICE, lane = local % SLICE;
  vec3 pi = direction[i].xyz;
  mat3 s = mat3(0.0);
  for (uint row = slice_begin[slice]; row < slice_begin[slice + 1]; ++row) {
    uint entry = 32 * row + lane;
    vec3 dp = direction[bond[entry]].xyz - pi;
    s += outerProduct(weight[entry] * dp, unpack_bond(bond[entry + 16], unit));
  }
  mat3 inverse_shape = symmetric(shape[11 * stride + i], shape[12 * stride + i], shape[13 * stride + i],
                                 shape[14 * stride + i], shape[15 * stride + i], shape[16 * stride + i]);
  vec4 x = tangent[4 * i], y = tangent[4 * i + 1], z = tangent[4 * i + 2];
  mat3 f = transpose(mat3(x.xyz, y.xyz, z.xyz)), df = (shape[i] * s) * inverse_shape;
  mat3 cof = cofactor(f);
  float along = (1.0 + shape[stride + i] / 1.5) * inner(cof, df);
  mat3 stress = (1.0 + y.w) * df + along * cof + x.w * cofactor_change(f, df);
  mat3 da = df - stress * (inverse_shape / 3.0);
  record[3 * i] = vec4(da[0][0], da[1][0], da[2][0], pi.x);
  record[3 * i + 1] = vec4(da[0][1], da[1][1], da[2][1], pi.y);
  record[3 * i + 2] = vec4(da[0][2], da[1][2], da[2][2], pi.z);
}
