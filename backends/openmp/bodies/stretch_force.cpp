// Forces of law M3, gathered; see kernels/stretch_force.decl.
#include "kernels/stretch_force.h"
#include "backends/openmp/basis.h"
#include "backends/openmp/body.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_force(const kernels::stretch_force::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const auto ui = k.stretch_record[2 * std::size_t{i}], yi = k.stretch_record[2 * std::size_t{i} + 1];
    const uint row_i = static_cast<uint>(yi.w);
    const bool squared_i = k.energies[row_i].x > 0;
    Vec3<real> sum{0, 0, 0};
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
        });
    k.force[i] = {sum.x, sum.y, sum.z, k.linear_start[i].w};
  }
}

PLIANT_BODY(stretch_force)

} // namespace pliant::openmp::PLIANT_ISA
