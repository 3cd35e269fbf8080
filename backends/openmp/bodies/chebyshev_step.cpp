// One accelerated Jacobi iteration; see kernels/chebyshev_step.decl.
#include "kernels/chebyshev_step.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"
#include "shaders/common/touched.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

// omega of Chebyshev's recurrence after m accelerated iterations, in closed form:
// omega_m = (2 / rho) T_m(1 / rho) / T_(m+1)(1 / rho) with T_m(cosh a) = cosh(m a); omega_0 = 1.
template <class real> real chebyshev_omega(real m, real one_minus_rho) {
  const double rho = 1.0 - static_cast<double>(one_minus_rho), n = static_cast<double>(m);
  if (n < 1 || rho <= 0) return 1;
  const double excess = static_cast<double>(one_minus_rho) / rho; // 1 / rho - 1
  const double a = __builtin_log1p(excess + __builtin_sqrt(excess * (excess + 2)));
  const double up = 1 + __builtin_exp(-2 * n * a), down = 1 + __builtin_exp(-2 * (n + 1) * a);
  return static_cast<real>(2 / rho * __builtin_exp(-a) * up / down);
}

} // namespace

template <class real> void chebyshev_step(const kernels::chebyshev_step::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
  const real since = static_cast<real>(k.iteration) - k.solver[SOLVER_START];
  const real m = k.solver[SOLVER_ACCELERATE] > 0 ? since - k.solver[SOLVER_DELAY] + 1 : 0;
  const real omega = chebyshev_omega(m, k.solver[SOLVER_ONE_MINUS_RHO]), gamma = k.solver[SOLVER_GAMMA];
  constexpr uint group = kernels::chebyshev_step::group_size;
  static_assert(group * 65536 * TOUCHED_UNIT <= 1);
  const Quad<real> no_w{1, 1, 1, 0};
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < (k.threads + group - 1) / group; ++block) {
    Quad<real> error{}, momentum{}, moved{};
    real mark = 0;
    for (uint i = group * block; i < smaller(group * (block + 1), k.threads); ++i) {
      const Quad<real> target = load_quad(k.inertia_target[i]), f = load_quad(k.force[i]);
      const Quad<real> u = load_quad(k.displacement[i]), u_earlier = load_quad(k.earlier_iterate[i]);
      const real inertia = target[3];
      if (inertia < 0) {
        store_quad(k.earlier_iterate[i], u * no_w);
        continue;
      }
      const real inverse_diagonal = 1 / (inertia + f[3]);
      const Quad<real> r = (inertia * (target - u) + f) * no_w;
      Quad<real> u_next = omega * ((gamma * inverse_diagonal) * r + (u - u_earlier)) + u_earlier;
      if (k.position) u_next = f[3] > 0 ? u + f / f[3] : target;
      if (k.checked) {
        const Quad<real> impulse = inertia * target * no_w;
        error += inverse_diagonal * (r * r);
        momentum += inverse_diagonal * (impulse * impulse);
        moved += (inertia + f[3]) * (u * u);
        if (k.contacts && k.touched[i])
          mark += real(TOUCHED_UNIT) * static_cast<real>(1 + ((i * 2654435761u) >> 16));
      }
      store_quad(k.earlier_iterate[i], u_next * no_w);
    }
    if (k.checked)
      k.residual_partial[block] = {error[0] + error[1] + error[2], momentum[0] + momentum[1] + momentum[2],
                                   moved[0] + moved[1] + moved[2], mark};
  }
}

PLIANT_BODY(chebyshev_step)

} // namespace pliant::openmp::PLIANT_ISA
