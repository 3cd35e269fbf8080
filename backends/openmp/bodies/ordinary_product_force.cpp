// See kernels/ordinary_product_force.decl.
#include "kernels/ordinary_product_force.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_product_force(const kernels::ordinary_product_force::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint local = 0; local < k.threads; ++local) {
      const uint i = k.first + local;
      const auto yi = k.tangent[4 * std::size_t{i}], pi = k.extension[i];
      Vec3<real> sum{0, 0, 0};
      for_each_bond_at_rest<plastic()>(k, local, [&](uint j, Vec3<real> xi, const RestBond<real>& at_rest) {
        const auto [c_out, c_in, p_out, p_in] = at_rest;
        const auto yj = k.tangent[4 * std::size_t{j}], pj = k.extension[j];
        const Vec3<real> y = xyz(yj) - xyz(yi), dy = xyz(pj) - xyz(pi), n = bond_direction(y, xi);
        const real x = norm(xi), size = norm(y), along = dot(n, dy), x_out = x * p_out, x_in = x * p_in;
        const real pull = c_out * (size - x_out + x_out * yi.w) + c_in * (size - x_in + x_in * yj.w);
        const real pull_rate = (c_out + c_in) * along + x * (c_out * p_out * pi.w + c_in * p_in * pj.w);
        const real across = pull / larger(size, real(1e-3) * x + real(1e-30));
        sum = sum + pull_rate * n + across * (dy - along * n);
      });
      k.force[i] = {sum.x, sum.y, sum.z, 0};
    }
  });
}

PLIANT_BODY(ordinary_product_force)

} // namespace pliant::openmp::PLIANT_ISA
