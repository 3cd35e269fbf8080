// What pushes an inverted neighbourhood back; see kernels/inversion_state.decl.
#include "kernels/inversion_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "backends/openmp/symmetric.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void inversion_state(const kernels::inversion_state::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    const real push = k.inversion_shape[k.stride + i];
    Mat3<real> b = zero_matrix<real>();
    real share = 0;
    if (push > 0) {
      Mat3<real> s = zero_matrix<real>();
      for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
        add_outer(s, c_out, (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui), xi);
      });
      const Mat3<real> inverse_shape = symmetric_rows(k.inversion_shape, 3, k.stride, i);
      const Mat3<real> f = scaled(k.inversion_shape[i], s) * inverse_shape;
      const Mat3<real> off = f - clamp_singular_values(f, real(0.1));
      b = scaled(push, off) * inverse_shape;
      if (inner(off, off) > 0) share = k.inversion_shape[std::size_t{2} * k.stride + i];
    }
    store_rows(k.inversion + 3 * std::size_t{i}, b, share, real(0), real(0));
  }
}

PLIANT_BODY(inversion_state)

} // namespace pliant::openmp::PLIANT_ISA
