// Energy of law M3 at each particle; see kernels/stretch_energy.decl.
#include "kernels/stretch_energy.h"
#include "backends/openmp/basis_wide.h"
#include "backends/openmp/body.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_energy(const kernels::stretch_energy::View<real>& k) {
  const real unit = grid_unit(k.unit);
  const auto one_by_one = [&](uint local) {
    const uint i = k.first + local, row0 = static_cast<uint>(k.shape[2 * std::size_t{k.stride} + i]);
    const bool squared = k.energies[row0].x > 0;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    real stretching = 0, lengthening = 0;
    for_each_bond_of_strength(k, local, [&](uint j, Vec3<real> xi, real c_out, real, real g_out, real) {
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
      const real x = norm(xi), per_x = x > 0 ? 1 / x : 0, size = norm(y);
      const real h = g_out * basis_value(k.energies + row0 + STRETCH_BOND, (size - x) * per_x);
      stretching += c_out * x * x * h;
      lengthening += c_out * lengthening_of(size, x, squared);
    });
    const real inverse_modulus = k.shape[i], e = dilatation_of(inverse_modulus * lengthening, squared);
    const real volumetric =
        inverse_modulus > 0 ? basis_value(k.energies + row0 + STRETCH_VOLUME, e) / inverse_modulus : 0;
    k.energy[i] = (stretching + volumetric) / 2;
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
      const Real4<real>* const energies = k.energies + static_cast<uint>(rows[0]);
      const bool squared = energies[0].x > 0;
      const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
      const Wide<real> none{};
      Wide<real> stretching{}, lengthening{};
      for_each_bond_of_strength_of_part(
          k, local,
          [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>, Wide<real> g_out, Wide<real>) {
            const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
            const Wide3<real> y{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                                (yj.z - yi.z) + (uj.z - ui.z)};
            const Wide<real> x = unit * root_wide<real>(dot(xi, xi)), size = root_wide<real>(dot(y, y));
            const Wide<real> e = x > 0 ? (size - x) / x : none;
            stretching += c_out * g_out * x * x * basis_value<real>(energies + STRETCH_BOND, e);
            lengthening += c_out * lengthening_of<real>(size, x, squared);
          });
      const Wide<real> inverse_modulus = load_wide(k.shape + i);
      const Wide<real> e = dilatation_of<real>(inverse_modulus * lengthening, squared);
      const Wide<real> volumetric = basis_value<real>(energies + STRETCH_VOLUME, e) / inverse_modulus;
      store_reals(k.energy + i, part.count, (stretching + (inverse_modulus > 0 ? volumetric : none)) / 2);
    });
}

PLIANT_BODY(stretch_energy)

} // namespace pliant::openmp::PLIANT_ISA
