// Forces of law M3, gathered; see kernels/stretch_force.decl.
#include "kernels/stretch_force.h"
#include "backends/openmp/basis_wide.h"
#include "backends/openmp/body.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_force(const kernels::stretch_force::View<real>& k) {
  if (k.gate[0].x > 0) return; // SOLVER_STOP
  const real unit = grid_unit(k.unit);
  const auto one_by_one = [&](uint local) {
    const uint i = k.first + local;
    const auto ui = k.stretch_record[2 * std::size_t{i}], yi = k.stretch_record[2 * std::size_t{i} + 1];
    const uint row_i = static_cast<uint>(yi.w);
    const bool squared_i = k.energies[row_i].x > 0;
    Vec3<real> sum{0, 0, 0};
    real stretching = 0;
    for_each_bond_of_strength(
        k, local, [&](uint j, Vec3<real> xi, real c_out, real c_in, real g_out, real g_in) {
          const auto uj = k.stretch_record[2 * std::size_t{j}], yj = k.stretch_record[2 * std::size_t{j} + 1];
          const Vec3<real> y = (xyz(yj) - xyz(yi)) + (xyz(uj) - xyz(ui));
          const real x = norm(xi), per_x = x > 0 ? 1 / x : 0, size = norm(y);
          const real e = (size - x) * per_x, s = size * per_x;
          const uint row_j = static_cast<uint>(yj.w);
          const bool squared_j = k.energies[row_j].x > 0;
          const real h_i = basis_slopes(k.energies + row_i + STRETCH_BOND, e).first / 2;
          const real h_j =
              row_j == row_i ? h_i : basis_slopes(k.energies + row_j + STRETCH_BOND, e).first / 2;
          const real out_pull = ui.w * (squared_i ? s : 1) + g_out * h_i;
          const real in_pull = uj.w * (squared_j ? s : 1) + g_in * h_j;
          sum = sum + x * (c_out * out_pull + c_in * in_pull) * bond_direction(y, xi);
          if (k.potential)
            stretching += c_out * g_out * x * x * basis_value(k.energies + row_i + STRETCH_BOND, e);
        });
    if (k.potential) k.energy[i] += stretching / 2;
    k.force[i] = {sum.x, sum.y, sum.z, k.linear_start[i].w};
  };
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> ui = gather<2>(k.stretch_record, part.index),
                        yi = gather<2>(k.stretch_record + 1, part.index);
      if (!alike<real>(yi.w)) {
        for (uint lane = 0; lane < part.count; ++lane) one_by_one(local + lane);
        return;
      }
      const Real4<real>* const energies = k.energies + static_cast<uint>(yi.w[0]);
      const bool squared = energies[0].x > 0, valued = k.potential != 0;
      const BasisTerms<real> terms(energies + STRETCH_BOND);
      Wide3<real> sum{};
      Wide<real> stretching{};
      for_each_bond_of_strength_of_part(
          k, local,
          [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real> c_in, Wide<real> g_out,
              Wide<real> g_in) {
            const Wide4<real> uj = gather<2>(k.stretch_record, j), yj = gather<2>(k.stretch_record + 1, j);
            const Wide3<real> y{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                                (yj.z - yi.z) + (uj.z - ui.z)};
            const WideBond<real> b = wide_bond<real>(y, xi, unit);
            const Wide<real> e = (b.size - b.x) * b.per_x;
            const WideBasis<real> basis = valued ? basis_at<true>(terms, e) : basis_at<false>(terms, e);
            const Wide<real> h = basis.slope / 2;
            const Wide<real> lever = squared ? b.size : b.x; // x s
            const Wide<real> pull =
                lever * (c_out * ui.w + c_in * uj.w) + b.x * h * (c_out * g_out + c_in * g_in);
            sum = {sum.x + pull * b.n.x, sum.y + pull * b.n.y, sum.z + pull * b.n.z};
            if (valued) stretching += c_out * g_out * b.x * b.x * basis.value;
          });
      const Wide4<real> start = gather(k.linear_start, part.index);
      store(k.force + i, part.count, Wide4<real>{sum.x, sum.y, sum.z, start.w});
      if (k.potential) store_reals(k.energy + i, part.count, load_wide(k.energy + i) + stretching / 2);
    });
}

PLIANT_BODY(stretch_force)

} // namespace pliant::openmp::PLIANT_ISA
