// The deformation gradient of each particle; see kernels/deformation.decl.
#include "kernels/deformation.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// Inverse of a symmetric positive matrix by cofactors.
template <class real> Mat3<real> symmetric_inverse(const Mat3<real>& a) {
  const real xx = a.m[0][0], xy = a.m[0][1], xz = a.m[0][2], yy = a.m[1][1], yz = a.m[1][2], zz = a.m[2][2];
  const real cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
  const real s = 1 / (xx * cxx + xy * cxy + xz * cxz);
  const real cyy = xx * zz - xz * xz, cyz = xy * xz - xx * yz, czz = xx * yy - xy * xy;
  return {{{s * cxx, s * cxy, s * cxz}, {s * cxy, s * cyy, s * cyz}, {s * cxz, s * cyz, s * czz}}};
}

} // namespace

template <class real> void deformation(const kernels::deformation::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]);
    Mat3<real> yx = zero_matrix<real>(), xx = zero_matrix<real>();
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      add_outer(yx, c_out, xyz(k.position[j]) - yi, xi);
      add_outer(xx, c_out, xi, xi);
    });
    const real trace = xx.m[0][0] + xx.m[1][1] + xx.m[2][2];
    Mat3<real> f{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    if (trace > 0) {
      const Mat3<real> r = rotation_matrix(horn_rotation(yx));
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          yx.m[a][b] = yx.m[a][b] / trace + real(1e-3) * r.m[a][b];
          xx.m[a][b] = xx.m[a][b] / trace + (a == b ? real(1e-3) : real(0));
        }
      f = yx * symmetric_inverse(xx);
    }
    Mat3<real> e = transposed_product(f, f); // Green strain, then its deviator
    const real mean = (e.m[0][0] + e.m[1][1] + e.m[2][2]) / 3;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) e.m[a][b] = (e.m[a][b] - (a == b ? mean : real(0))) / 2;
    const real strain = root(real(2) / 3 * inner(e, e));
    k.gradient[3 * i] = {f.m[0][0], f.m[0][1], f.m[0][2], strain};
    k.gradient[3 * i + 1] = {f.m[1][0], f.m[1][1], f.m[1][2], 0};
    k.gradient[3 * i + 2] = {f.m[2][0], f.m[2][1], f.m[2][2], 0};
  }
}

PLIANT_BODY(deformation)

} // namespace pliant::openmp::PLIANT_ISA
