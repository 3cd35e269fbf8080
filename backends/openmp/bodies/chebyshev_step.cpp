// One accelerated Jacobi iteration; see kernels/chebyshev_step.decl.
#include "kernels/chebyshev_step.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

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
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < (k.threads + group - 1) / group; ++block) {
    real sum = 0;
    for (uint i = group * block; i < smaller(group * (block + 1), k.threads); ++i) {
      const auto target = k.inertia_target[i], f = k.force[i];
      const Vec3<real> u = xyz(k.displacement[i]), u_earlier = xyz(k.earlier_iterate[i]);
      if (target.w < 0) {
        k.earlier_iterate[i] = {u.x, u.y, u.z, 0};
        continue;
      }
      const real diagonal = target.w + f.w;
      const Vec3<real> r = target.w * (xyz(target) - u) + xyz(f);
      const Vec3<real> u_next = omega * ((gamma / diagonal) * r + (u - u_earlier)) + u_earlier;
      sum += dot(r, r) / diagonal;
      k.earlier_iterate[i] = {u_next.x, u_next.y, u_next.z, 0};
    }
    if (k.checked) k.residual_partial[block] = sum;
  }
}

PLIANT_BODY(chebyshev_step)

} // namespace pliant::openmp::PLIANT_ISA
