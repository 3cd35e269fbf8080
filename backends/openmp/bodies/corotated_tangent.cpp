// See kernels/corotated_tangent.decl.
#include "kernels/corotated_tangent.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_rotation.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_tangent(const kernels::corotated_tangent::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> ui = gather(k.displacement, part.index);
      WideMat3<real> s{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>) {
        const Wide4<real> uj = gather(k.displacement, j);
        add_outer(s, Wide3<real>{c_out * (uj.x - ui.x), c_out * (uj.y - ui.y), c_out * (uj.z - ui.z)}, xi);
      });
      const Wide<real> inverse_modulus = load_wide(k.shape + i);
      const real* start = k.shape + std::size_t{2} * k.stride + i; // sum c Yn (x) xi
      for (Wide<real>* value : {&s.x.x, &s.x.y, &s.x.z, &s.y.x, &s.y.y, &s.y.z, &s.z.x, &s.z.y, &s.z.z}) {
        *value = inverse_modulus * (unit * *value + load_wide(start));
        start += k.stride;
      }
      const Wide4<real> q = gather(k.rotation, part.index);
      const WideMat3<real> u = transposed_product(rotation_matrix<real>(q), s);
      const Wide<real> theta = u.x.x + u.y.y + u.z.z, coupling = load_wide(k.shape + k.stride + i);
      Wide<real> xx = theta - u.x.x, yy = theta - u.y.y, zz = theta - u.z.z;
      const Wide<real> xy = (u.x.y + u.y.x) / -2, xz = (u.x.z + u.z.x) / -2, yz = (u.y.z + u.z.y) / -2;
      Wide<real> rest = Wide<real>{} + 1;
      if (k.failing) rest = load_wide(k.shape + std::size_t{k.share_row} * k.stride + i);
      const Wide<real> scale = 1 - coupling * (theta - rest), none{};
      const Wide<real> kept = k.flat ? scale : scale * 2 / 3;
      const Wide<real> fiftieth = none + real(0.02);
      Wide<real> lowest = fiftieth; // of an eigenvalue
      if (k.solver[SOLVER_CONVEX] > 0) lowest = kept > fiftieth ? kept : fiftieth;
      const Wide<real> axy = magnitudes<real>(xy), axz = magnitudes<real>(xz), ayz = magnitudes<real>(yz);
      const Wide<real> low_x = xx - axy - axz, low_y = yy - axy - ayz, low_z = zz - axz - ayz;
      const Wide<real> low_xy = low_x < low_y ? low_x : low_y;
      Wide<real> least = low_xy < low_z ? low_xy : low_z;
      // Gershgorin's bound, then Newton's method on the characteristic polynomial, which nears the least root
      // from below.
      const Wide<real> c1 = xx + yy + zz, c2 = xx * yy + yy * zz + zz * xx - xy * xy - xz * xz - yz * yz;
      const Wide<real> c3 = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
      const Wide<real> flat = real(1e-6) * c1 * c1 + real(1e-30);
      for (int step = 0; step < 8; ++step) {
        const Wide<real> slope = (3 * least - 2 * c1) * least + c2;
        const Wide<real> value = ((least - c1) * least + c2) * least - c3;
        least -= (value < 0 ? value : none) / (slope > flat ? slope : flat);
      }
      const Wide<real> missing = lowest - least, raise = missing > 0 ? missing : none;
      xx += raise, yy += raise, zz += raise;
      const Wide<real> cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
      const Wide<real> f = 1 / (xx * cxx + xy * cxy + xz * cxz);
      Real4<real>* const tangent = k.tangent + 4 * std::size_t{i};
      store<4>(tangent, part.count, q);
      store<4>(tangent + 1, part.count, Wide4<real>{f * cxx, f * cxy, f * cxz, f * (xx * zz - xz * xz)});
      store<4>(tangent + 2, part.count,
               Wide4<real>{f * (xy * xz - xx * yz), f * (xx * yy - xy * xy), scale, coupling});
      store<4>(tangent + 3, part.count, Wide4<real>{inverse_modulus, none, none, none});
    });
}

PLIANT_BODY(corotated_tangent)

} // namespace pliant::openmp::PLIANT_ISA
