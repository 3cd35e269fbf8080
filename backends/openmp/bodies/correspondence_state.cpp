// Local step of law M5, neo-Hookean; see kernels/correspondence_state.decl.
#include "kernels/correspondence_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_rotation.h"
#include "backends/openmp/simd_tensor.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void correspondence_state(const kernels::correspondence_state::View<real>& k) {
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
      const WideMat3<real> inverse_shape = symmetric_rows_wide(k.shape, 11, k.stride, i);
      const WideMat3<real> f = product<real>(s, inverse_shape), cof = cofactor<real>(f);
      const Wide<real> stiffness = 1 + load_wide(k.shape + k.stride + i) / real(1.5); // lambda / mu
      const Wide<real> pressure = stiffness * (dot(f.x, cof.x) - 1) - 1; // (lambda / mu)(J - alpha)
      const WideMat3<real> stress = product<real>(plus<real>(f, pressure, cof), inverse_shape);
      const WideMat3<real> a = plus<real>(f, spread(real(-1) / 3), stress);
      const Wide4<real> q = polar_rotation(f, gather(k.rotation, part.index), part.count);
      store(k.rotation + i, part.count, q);
      Real4<real>* const record = k.record + 3 * std::size_t{i};
      store<3>(record, part.count, Wide4<real>{a.x.x, a.x.y, a.x.z, ui.x});
      store<3>(record + 1, part.count, Wide4<real>{a.y.x, a.y.y, a.y.z, ui.y});
      store<3>(record + 2, part.count, Wide4<real>{a.z.x, a.z.y, a.z.z, ui.z});
    });
}

PLIANT_BODY(correspondence_state)

} // namespace pliant::openmp::PLIANT_ISA
