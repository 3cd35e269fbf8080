// See kernels/ordinary_product.decl.
#include "kernels/ordinary_product.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_product(const kernels::ordinary_product::View<real>& k) {
  if ((k.plastic ? k.gate[3].y : k.solver[SOLVER_LINEAR]) == 0) return;
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint local = 0; local < k.threads; ++local) {
      const uint i = k.first + local;
      const Vec3<real> yi = xyz(k.tangent[4 * std::size_t{i}]), pi = xyz(k.direction[i]);
      real lengthening = 0;
      for_each_bond_at_rest<plastic()>(k, local, [&](uint j, Vec3<real> xi, const RestBond<real>& at_rest) {
        const Vec3<real> n = bond_direction(xyz(k.tangent[4 * std::size_t{j}]) - yi, xi);
        lengthening += at_rest.c_out * (norm(xi) * at_rest.p_out) * dot(n, xyz(k.direction[j]) - pi);
      });
      k.extension[i] = {pi.x, pi.y, pi.z, k.shape[k.stride + i] * k.shape[i] * lengthening};
    }
  });
}

PLIANT_BODY(ordinary_product)

} // namespace pliant::openmp::PLIANT_ISA
