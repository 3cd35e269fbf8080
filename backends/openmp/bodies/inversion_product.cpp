// See kernels/inversion_product.decl.
#include "kernels/inversion_product.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "backends/openmp/symmetric.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void inversion_product(const kernels::inversion_product::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    Mat3<real> b = zero_matrix<real>();
    if (k.inverted[i] > 0) {
      const Vec3<real> pi = xyz(k.direction[i]);
      for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
        add_outer(b, c_out, xyz(k.direction[j]) - pi, xi);
      });
      const Mat3<real> inverse_shape = symmetric_rows(k.inversion_shape, 3, k.stride, i);
      b = scaled(k.inversion_shape[k.stride + i] * k.inversion_shape[i], b) * inverse_shape * inverse_shape;
    }
    store_rows(k.inversion + 3 * std::size_t{i}, b, real(0), real(0), real(0));
  }
}

PLIANT_BODY(inversion_product)

} // namespace pliant::openmp::PLIANT_ISA
