// See kernels/stretch_tangent.decl.
#include "kernels/stretch_tangent.h"
#include "backends/openmp/basis_wide.h"
#include "backends/openmp/body.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_tangent(const kernels::stretch_tangent::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
  const real unit = grid_unit(k.unit);
  const bool convex = k.solver[SOLVER_CONVEX] > 0;
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
    const real e = dilatation_of(k.shape[i] * lengthening, squared);
    const Slopes<real> slopes = basis_slopes(k.energies + row0 + STRETCH_VOLUME, e);
    real phi = slopes.first / 2, rate = slopes.second / 2;
    if (squared) {
      const real theta = larger(1 + e, real(1e-6));
      phi /= theta;
      rate = (rate - phi) / (theta * theta);
    }
    if (convex) rate = larger(rate, real(0));
    k.tangent[4 * std::size_t{i}] = {yi.x + ui.x, yi.y + ui.y, yi.z + ui.z, phi};
    k.tangent[4 * std::size_t{i} + 1] = {place, k.shape[i] * rate, 0, 0};
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
      Wide<real> lengthening{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>) {
        const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
        const Wide3<real> y{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                            (yj.z - yi.z) + (uj.z - ui.z)};
        const Wide<real> x = unit * root_wide<real>(dot(xi, xi)), size = root_wide<real>(dot(y, y));
        lengthening += c_out * lengthening_of<real>(size, x, squared);
      });
      const Wide<real> inverse_modulus = load_wide(k.shape + i), none{};
      const Wide<real> e = dilatation_of<real>(inverse_modulus * lengthening, squared);
      const WideSlopes<real> slopes = basis_slopes<real>(energies + STRETCH_VOLUME, e);
      Wide<real> phi = slopes.first / 2, rate = slopes.second / 2;
      if (squared) {
        const Wide<real> above = 1 + e, least = none + real(1e-6), theta = above > least ? above : least;
        phi /= theta;
        rate = (rate - phi) / (theta * theta);
      }
      if (convex) rate = rate > 0 ? rate : none;
      Real4<real>* const tangent = k.tangent + 4 * std::size_t{i};
      store<4>(tangent, part.count, Wide4<real>{yi.x + ui.x, yi.y + ui.y, yi.z + ui.z, phi});
      store<4>(tangent + 1, part.count, Wide4<real>{rows, inverse_modulus * rate, none, none});
    });
}

PLIANT_BODY(stretch_tangent)

} // namespace pliant::openmp::PLIANT_ISA
