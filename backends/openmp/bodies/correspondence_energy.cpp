// Energy of law M5, neo-Hookean, at each particle; see kernels/correspondence_energy.decl.
#include "kernels/correspondence_energy.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_rotation.h"
#include "backends/openmp/simd_tensor.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void correspondence_energy(const kernels::correspondence_energy::View<real>& k) {
  if (k.gated && k.gate[0].x > 0) return; // SOLVER_STOP
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
      const WideMat3<real> r = rotation_matrix<real>(gather(k.rotation, part.index));
      WideMat3<real> d{};
      Wide<real> deviation{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> code, Wide<real> c_out, Wide<real>) {
        const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
        const Wide3<real> xi{unit * code.x, unit * code.y, unit * code.z}, target = r * xi;
        const Wide3<real> off{(yj.x - yi.x) + (uj.x - ui.x) - target.x,
                              (yj.y - yi.y) + (uj.y - ui.y) - target.y,
                              (yj.z - yi.z) + (uj.z - ui.z) - target.z};
        deviation += c_out * dot(off, off);
        add_outer(d, Wide3<real>{c_out * off.x, c_out * off.y, c_out * off.z}, xi);
      });
      const Wide<real> inverse_modulus = load_wide(k.shape + i);
      const WideMat3<real> inverse_shape = symmetric_rows_wide(k.shape, 11, k.stride, i);
      const WideMat3<real> excess = product<real>(times<real>(inverse_modulus, d), inverse_shape); // F - R
      const WideMat3<real> h = transposed_product(r, excess);
      const Wide<real> trace = h.x.x + h.y.y + h.z.z;
      const Wide<real> pairs =
          (h.x.x * h.y.y - h.x.y * h.y.x) + (h.x.x * h.z.z - h.x.z * h.z.x) + (h.y.y * h.z.z - h.y.z * h.z.y);
      const Wide<real> volume = dot(h.x, cross<real>(h.y, h.z)), growth = trace + pairs + volume; // J - 1
      const Wide<real> stiffness = 1 + load_wide(k.shape + k.stride + i) / real(1.5); // lambda / mu
      const Wide<real> affine = inner(h, h) / 2 - pairs - volume + stiffness * growth * growth / 2;
      const Wide<real> rest = deviation - inner(excess, d); // what no gradient explains
      const Wide<real> whole = affine / (3 * inverse_modulus);
      store_reals(k.energy + i, part.count, (inverse_modulus > 0 ? whole : Wide<real>{}) + rest / 2);
    });
}

PLIANT_BODY(correspondence_energy)

} // namespace pliant::openmp::PLIANT_ISA
