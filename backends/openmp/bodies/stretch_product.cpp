// See kernels/stretch_product.decl.
#include "kernels/stretch_product.h"
#include "backends/openmp/basis.h"
#include "backends/openmp/body.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_product(const kernels::stretch_product::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
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
  }
}

PLIANT_BODY(stretch_product)

} // namespace pliant::openmp::PLIANT_ISA
