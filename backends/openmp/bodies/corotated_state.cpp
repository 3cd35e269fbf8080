// Local step of law M4; see kernels/corotated_state.decl.
#include "kernels/corotated_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_rotation.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_state(const kernels::corotated_state::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
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
      const Wide4<real> before = gather(k.rotation, part.index);
      const Wide4<real> q = k.plane ? plane_rotation(s, before) : polar_rotation(s, before, part.count);
      const WideMat3<real> r = rotation_matrix<real>(q);
      const Wide<real> theta = inner(r, s);
      Wide<real> rest = Wide<real>{} + 1;
      if (k.failing) rest = load_wide(k.shape + std::size_t{k.share_row} * k.stride + i);
      const Wide<real> scale = 1 - load_wide(k.shape + k.stride + i) * (theta - rest);
      store(k.rotation + i, part.count, q);
      Real4<real>* const record = k.record + 3 * std::size_t{i};
      store<3>(record, part.count, Wide4<real>{scale * r.x.x, scale * r.x.y, scale * r.x.z, ui.x});
      store<3>(record + 1, part.count, Wide4<real>{scale * r.y.x, scale * r.y.y, scale * r.y.z, ui.y});
      store<3>(record + 2, part.count, Wide4<real>{scale * r.z.x, scale * r.z.y, scale * r.z.z, ui.z});
    });
}

PLIANT_BODY(corotated_state)

} // namespace pliant::openmp::PLIANT_ISA
