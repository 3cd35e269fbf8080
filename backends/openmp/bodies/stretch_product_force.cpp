// See kernels/stretch_product_force.decl.
#include "kernels/stretch_product_force.h"
#include "backends/openmp/basis_wide.h"
#include "backends/openmp/body.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_product_force(const kernels::stretch_product_force::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  const bool convex = k.solver[SOLVER_CONVEX] > 0;
  const real unit = grid_unit(k.unit);
  const auto one_by_one = [&](uint local) {
    const uint i = k.first + local;
    const auto yi = k.tangent[4 * std::size_t{i}], pi = k.stretch_record[2 * std::size_t{i}];
    const uint row_i = static_cast<uint>(k.tangent[4 * std::size_t{i} + 1].x);
    const bool squared_i = k.energies[row_i].x > 0;
    Vec3<real> sum{0, 0, 0};
    for_each_bond_of_strength(
        k, local, [&](uint j, Vec3<real> xi, real c_out, real c_in, real g_out, real g_in) {
          const auto yj = k.tangent[4 * std::size_t{j}], pj = k.stretch_record[2 * std::size_t{j}];
          const uint row_j = static_cast<uint>(k.tangent[4 * std::size_t{j} + 1].x);
          const bool squared_j = k.energies[row_j].x > 0;
          const Vec3<real> y = xyz(yj) - xyz(yi), dy = xyz(pj) - xyz(pi), n = bond_direction(y, xi);
          const real x = norm(xi), per_x = x > 0 ? 1 / x : 0, size = norm(y), along = dot(n, dy);
          const real e = (size - x) * per_x, s = size * per_x, s_i = squared_i ? s : 1,
                     s_j = squared_j ? s : 1;
          const Slopes<real> h_i = basis_slopes(k.energies + row_i + STRETCH_BOND, e);
          const Slopes<real> h_j = row_j == row_i ? h_i : basis_slopes(k.energies + row_j + STRETCH_BOND, e);
          const real pull =
              x * (c_out * (yi.w * s_i + g_out * h_i.first / 2) + c_in * (yj.w * s_j + g_in * h_j.first / 2));
          real stiffness = c_out * ((squared_i ? yi.w : 0) + g_out * h_i.second / 2) +
                           c_in * ((squared_j ? yj.w : 0) + g_in * h_j.second / 2);
          real across = pull / larger(size, real(1e-3) * x + real(1e-30));
          if (convex) {
            stiffness = larger(stiffness, real(0));
            across = larger(across, real(0));
          }
          const real pull_rate = stiffness * along + x * (c_out * pi.w * s_i + c_in * pj.w * s_j);
          sum = sum + pull_rate * n + across * (dy - along * n);
        });
    k.force[i] = {sum.x, sum.y, sum.z, 0};
  };
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> yi = gather<4>(k.tangent, part.index), kept = gather<4>(k.tangent + 1, part.index);
      if (!alike<real>(kept.x)) {
        for (uint lane = 0; lane < part.count; ++lane) one_by_one(local + lane);
        return;
      }
      const Real4<real>* const energies = k.energies + static_cast<uint>(kept.x[0]);
      const bool squared = energies[0].x > 0;
      const Wide4<real> pi = gather<2>(k.stretch_record, part.index);
      const Wide<real> none{};
      Wide3<real> sum{};
      for_each_bond_of_strength_of_part(
          k, local,
          [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real> c_in, Wide<real> g_out,
              Wide<real> g_in) {
            const Wide4<real> yj = gather<4>(k.tangent, j), pj = gather<2>(k.stretch_record, j);
            const WideBond<real> b =
                wide_bond<real>(Wide3<real>{yj.x - yi.x, yj.y - yi.y, yj.z - yi.z}, xi, unit);
            const Wide3<real> dy{pj.x - pi.x, pj.y - pi.y, pj.z - pi.z};
            const Wide<real> along = dot(b.n, dy), lever = squared ? b.size : b.x; // x s
            const WideSlopes<real> h = basis_slopes<real>(energies + STRETCH_BOND, (b.size - b.x) * b.per_x);
            const Wide<real> volume = c_out * yi.w + c_in * yj.w, strong = c_out * g_out + c_in * g_in;
            const Wide<real> pull = lever * volume + b.x * strong * h.first / 2;
            Wide<real> stiffness = strong * h.second / 2;
            if (squared) stiffness += volume;
            const Wide<real> least = real(1e-3) * b.x + real(1e-30);
            Wide<real> across = pull / (b.size > least ? b.size : least);
            if (convex) {
              stiffness = stiffness > 0 ? stiffness : none;
              across = across > 0 ? across : none;
            }
            const Wide<real> pull_rate =
                stiffness * along + lever * (c_out * pi.w + c_in * pj.w) - across * along;
            sum = {sum.x + pull_rate * b.n.x + across * dy.x, sum.y + pull_rate * b.n.y + across * dy.y,
                   sum.z + pull_rate * b.n.z + across * dy.z};
          });
      store(k.force + i, part.count, Wide4<real>{sum.x, sum.y, sum.z, none});
    });
}

PLIANT_BODY(stretch_product_force)

} // namespace pliant::openmp::PLIANT_ISA
