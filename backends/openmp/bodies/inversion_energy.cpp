// Energy against inversion; see kernels/inversion_energy.decl.
#include "kernels/inversion_energy.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "backends/openmp/symmetric.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void inversion_energy(const kernels::inversion_energy::View<real>& k) {
  if (k.gated && k.gate[0].x > 0) return; // SOLVER_STOP
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const real push = k.inversion_shape[k.stride + i];
    if (!(push > 0)) continue;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    Mat3<real> s = zero_matrix<real>();
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      add_outer(s, c_out, (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui), xi);
    });
    const real inverse_modulus = k.inversion_shape[i];
    const Mat3<real> f = scaled(inverse_modulus, s) * symmetric_rows(k.inversion_shape, 3, k.stride, i);
    const Mat3<real> off = f - clamp_singular_values(f, real(0.1));
    k.energy[i] += push / inverse_modulus * inner(off, off) / 2;
  }
}

PLIANT_BODY(inversion_energy)

} // namespace pliant::openmp::PLIANT_ISA
