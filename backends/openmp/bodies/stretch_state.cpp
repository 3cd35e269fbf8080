// Local step of law M3; see kernels/stretch_state.decl.
#include "kernels/stretch_state.h"
#include "backends/openmp/basis_wide.h"
#include "backends/openmp/body.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_state(const kernels::stretch_state::View<real>& k) {
  if (k.gate[0].x > 0) return; // SOLVER_STOP
  const real unit = grid_unit(k.unit);
  const auto one_by_one = [&](uint local) {
    const uint i = k.first + local;
    const real place = k.shape[2 * std::size_t{k.stride} + i];
    const uint row0 = static_cast<uint>(place);
    const bool squared = k.energies[row0].x > 0;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    real lengthening = 0;
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
      lengthening += c_out * lengthening_of(norm(y), norm(xi), squared);
    });
    const real e = dilatation_of(k.shape[i] * lengthening, squared); // theta - 1
    real phi = basis_slopes(k.energies + row0 + STRETCH_VOLUME, e).first / 2;
    if (squared) phi /= larger(1 + e, real(1e-6));
    k.stretch_record[2 * std::size_t{i}] = {ui.x, ui.y, ui.z, phi};
    k.stretch_record[2 * std::size_t{i} + 1] = {yi.x, yi.y, yi.z, place};
    if (k.potential)
      k.energy[i] =
          k.shape[i] > 0 ? basis_value(k.energies + row0 + STRETCH_VOLUME, e) / (2 * k.shape[i]) : 0;
  };
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide<real> rows = load_wide(k.shape + 2 * std::size_t{k.stride} + i);
      if (!alike<real>(rows)) {
        for (uint lane = 0; lane < part.count; ++lane) one_by_one(local + lane);
        return;
      }
      const uint row0 = static_cast<uint>(rows[0]);
      const bool squared = k.energies[row0].x > 0;
      const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
      Wide<real> lengthening{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>) {
        const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
        const Wide3<real> y{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                            (yj.z - yi.z) + (uj.z - ui.z)};
        const Wide<real> x = unit * root_wide<real>(dot(xi, xi)), size = root_wide<real>(dot(y, y));
        lengthening += c_out * (size - x) * (squared ? (size + x) / 2 : x);
      });
      const Wide<real> inverse_modulus = load_wide(k.shape + i);
      Wide<real> e = inverse_modulus * lengthening; // theta - 1
      if (squared) {
        const Wide<real> square = 1 + 2 * e, none{};
        e = 2 * e / (1 + root_wide<real>(square > 0 ? square : none));
      }
      Wide<real> phi = basis_slopes<real>(k.energies + row0 + STRETCH_VOLUME, e).first / 2;
      if (squared) {
        const Wide<real> theta = 1 + e, least = Wide<real>{} + real(1e-6);
        phi /= theta > least ? theta : least;
      }
      Real4<real>* const record = k.stretch_record + 2 * std::size_t{i};
      store<2>(record, part.count, Wide4<real>{ui.x, ui.y, ui.z, phi});
      store<2>(record + 1, part.count, Wide4<real>{yi.x, yi.y, yi.z, rows});
      if (!k.potential) return;
      const Wide<real> value =
          basis_value<real>(k.energies + row0 + STRETCH_VOLUME, e) / (2 * inverse_modulus);
      store_reals(k.energy + i, part.count, inverse_modulus > 0 ? value : Wide<real>{});
    });
}

PLIANT_BODY(stretch_state)

} // namespace pliant::openmp::PLIANT_ISA
