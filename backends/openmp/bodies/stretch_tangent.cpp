// See kernels/stretch_tangent.decl.
#include "kernels/stretch_tangent.h"
#include "backends/openmp/basis.h"
#include "backends/openmp/body.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_tangent(const kernels::stretch_tangent::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
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
    if (k.solver[SOLVER_CONVEX] > 0) rate = larger(rate, real(0));
    k.tangent[4 * std::size_t{i}] = {yi.x + ui.x, yi.y + ui.y, yi.z + ui.z, phi};
    k.tangent[4 * std::size_t{i} + 1] = {place, k.shape[i] * rate, 0, 0};
  }
}

PLIANT_BODY(stretch_tangent)

} // namespace pliant::openmp::PLIANT_ISA
