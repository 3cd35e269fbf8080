// One accelerated Jacobi iteration; see kernels/chebyshev_step.decl.
#include "common/solver.glsl"
#include "common/touched.glsl"

#if checked
shared vec4 group_sum[128];
#endif

// omega of Chebyshev's recurrence after m accelerated iterations, in closed form:
// omega_m = (2 / rho) T_m(1 / rho) / T_(m+1)(1 / rho), T_m(cosh a) = cosh(m a); omega_0 = 1.
float chebyshev_omega(float m, float one_minus_rho) {
  float rho = 1.0 - one_minus_rho;
  if (m < 1.0 || rho <= 0.0) return 1.0;
  float excess = one_minus_rho / rho; // 1 / rho - 1
  float a = log(1.0 + excess + sqrt(excess * (excess + 2.0)));
  return (2.0 / rho) * exp(-a) * (1.0 + exp(-2.0 * m * a)) / (1.0 + exp(-2.0 * (m + 1.0) * a));
}

void main() {
  uint i = thread_index();
  if (solver[SOLVER_STOP] > 0.0) return;
  vec4 sums = vec4(0.0);
  if (i < threads) {
    vec4 target = inertia_target[i], f = force[i];
    vec3 u = displacement[i].xyz, u_earlier = earlier_iterate[i].xyz, u_next = u;
    if (target.w >= 0.0) {
      float diagonal = target.w + f.w;
      vec3 r = target.w * (target.xyz - u) + f.xyz;
      float since = float(iteration) - solver[SOLVER_START];
      float m = solver[SOLVER_ACCELERATE] > 0.0 ? since - solver[SOLVER_DELAY] + 1.0 : 0.0;
      float omega = chebyshev_omega(m, solver[SOLVER_ONE_MINUS_RHO]);
#if position
      u_next = f.w > 0.0 ? u + f.xyz / f.w : target.xyz;
#else
      u_next = omega * ((solver[SOLVER_GAMMA] / diagonal) * r + (u - u_earlier)) + u_earlier;
#endif
#if checked
      sums.xyz = vec3(dot(r, r) / diagonal, target.w * target.w * dot(target.xyz, target.xyz) / diagonal,
                      diagonal * dot(u, u));
#if contacts
      if (touched[i] != 0u) sums.w = TOUCHED_UNIT * float(1u + ((i * 2654435761u) >> 16));
#endif
#endif
    }
    earlier_iterate[i] = vec4(u_next, 0.0);
  }
#if checked
  uint lane = gl_LocalInvocationIndex;
  group_sum[lane] = sums;
  barrier();
  for (uint half_width = 64; half_width > 0; half_width /= 2) {
    if (lane < half_width) group_sum[lane] += group_sum[lane + half_width];
    barrier();
  }
  if (lane == 0) residual_partial[group_index()] = group_sum[0];
#endif
}
