// Local step of law M2; see kernels/ordinary_state.decl.
#include "kernels/ordinary_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_state(const kernels::ordinary_state::View<real>& k) {
  if ((k.plastic ? k.gate[0].x : k.solver[SOLVER_STOP]) > 0) return;
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint local = 0; local < k.threads; ++local) {
      const uint i = k.first + local;
      const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
      real lengthening = 0; // sum c x (y - x): the dilatation less one, without its cancellation
      for_each_bond_at_rest<plastic()>(k, local, [&](uint j, Vec3<real> xi, const RestBond<real>& at_rest) {
        const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
        const real x = norm(xi) * at_rest.p_out;
        lengthening += at_rest.c_out * x * (norm(y) - x);
      });
      const real phi = k.shape[k.stride + i] * k.shape[i] * lengthening;
      k.extension[i] = {ui.x, ui.y, ui.z, phi};
    }
  });
}

PLIANT_BODY(ordinary_state)

} // namespace pliant::openmp::PLIANT_ISA
