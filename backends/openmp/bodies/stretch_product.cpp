// See kernels/stretch_product.decl.
#include "kernels/stretch_product.h"
#include "backends/openmp/basis_wide.h"
#include "backends/openmp/body.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_product(const kernels::stretch_product::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  const real unit = grid_unit(k.unit);
  const auto one_by_one = [&](uint local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.tangent[4 * std::size_t{i}]), pi = xyz(k.direction[i]);
    const auto kept = k.tangent[4 * std::size_t{i} + 1];
    const bool squared = k.energies[static_cast<uint>(kept.x)].x > 0;
    real lengthening = 0;
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      const Vec3<real> y = xyz(k.tangent[4 * std::size_t{j}]) - yi;
      const real lever = squared ? norm(y) : norm(xi);
      lengthening += c_out * lever * dot(bond_direction(y, xi), xyz(k.direction[j]) - pi);
    });
    k.stretch_record[2 * std::size_t{i}] = {pi.x, pi.y, pi.z, kept.y * lengthening};
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
      const bool squared = k.energies[static_cast<uint>(kept.x[0])].x > 0;
      const Wide4<real> pi = gather(k.direction, part.index);
      Wide<real> lengthening{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>) {
        const Wide4<real> yj = gather<4>(k.tangent, j), pj = gather(k.direction, j);
        const WideBond<real> b =
            wide_bond<real>(Wide3<real>{yj.x - yi.x, yj.y - yi.y, yj.z - yi.z}, xi, unit);
        const Wide3<real> dy{pj.x - pi.x, pj.y - pi.y, pj.z - pi.z};
        lengthening += c_out * (squared ? b.size : b.x) * dot(b.n, dy);
      });
      store<2>(k.stretch_record + 2 * std::size_t{i}, part.count,
               Wide4<real>{pi.x, pi.y, pi.z, kept.y * lengthening});
    });
}

PLIANT_BODY(stretch_product)

} // namespace pliant::openmp::PLIANT_ISA
