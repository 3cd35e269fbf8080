// See kernels/residual.decl.
#include "kernels/residual.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void residual(const kernels::residual::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
  constexpr uint group = kernels::residual::group_size;
  const uint groups = (k.threads + group - 1) / group;
  const Quad<real> no_w{1, 1, 1, 0};
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < groups; ++block) {
    Quad<real> error{}, inertial{}, work{}, momentum{}, moved{};
    real stored = 0;
    for (uint i = group * block; i < smaller(group * (block + 1), k.threads); ++i) {
      const Quad<real> target = load_quad(k.inertia_target[i]), f = load_quad(k.force[i]);
      const Quad<real> u = load_quad(k.displacement[i]), best = load_quad(k.best_iterate[i]);
      const real inertia = target[3], inverse_diagonal = 1 / (inertia + f[3]);
      if (k.potential) stored += k.energy[i];
      if (inertia < 0) {
        k.residual[i] = {0, 0, 0, 0};
        continue;
      }
      const Quad<real> away = (target - u) * no_w, r = inertia * away + f * no_w;
      error += inverse_diagonal * (r * r);
      inertial += (inertia / 2) * (away * away);
      work += r * (u - best);
      const Quad<real> impulse = inertia * target * no_w;
      momentum += inverse_diagonal * (impulse * impulse);
      moved += (inertia + f[3]) * (u * u);
      store_quad(k.residual[i], Quad<real>{r[0], r[1], r[2], 1 / (inertia + k.relief * f[3])});
    }
    k.solve_partial[block] = {error[0] + error[1] + error[2],
                              inertial[0] + inertial[1] + inertial[2] + stored, work[0] + work[1] + work[2],
                              0};
    k.solve_partial[groups + block] = {momentum[0] + momentum[1] + momentum[2],
                                       moved[0] + moved[1] + moved[2], 0, 0};
  }
}

PLIANT_BODY(residual)

} // namespace pliant::openmp::PLIANT_ISA
