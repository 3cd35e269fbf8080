// Local step of law M3; see kernels/stretch_state.decl.
#include "kernels/stretch_state.h"
#include "backends/openmp/basis.h"
#include "backends/openmp/body.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void stretch_state(const kernels::stretch_state::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local, row0 = static_cast<uint>(k.shape[2 * std::size_t{k.stride} + i]);
    const bool squared = k.energies[row0].x > 0;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    real lengthening = 0;
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
      lengthening += c_out * lengthening_of(norm(y), norm(xi), squared);
    });
    const real e = dilatation_of(k.shape[i] * lengthening, squared); // theta - 1
    real phi = basis_slopes(k.energies + row0 + STRETCH_VOLUME, e).first / 2;
    if (squared) phi /= larger(1 + e, real(1e-6));
    k.stretch_record[2 * std::size_t{i}] = {ui.x, ui.y, ui.z, phi};
    k.stretch_record[2 * std::size_t{i} + 1] = {yi.x, yi.y, yi.z, static_cast<real>(row0)};
  }
}

PLIANT_BODY(stretch_state)

} // namespace pliant::openmp::PLIANT_ISA
