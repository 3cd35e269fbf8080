// Sums of basis functions on the CPU, from the table `energies` of law "basis".
#pragma once

#include "backends/openmp/slice.h"
#include "shaders/common/stretch.glsl"

namespace pliant::openmp::PLIANT_ISA {

PLIANT_INLINE float log_of_one_plus(float e) {
  return __builtin_log1pf(e);
}
PLIANT_INLINE double log_of_one_plus(double e) {
  return __builtin_log1p(e);
}

/// (e - ln(1 + e)) / e^2, which is 1/2 at e = 0. Near it by ln(1 + e) = 2 artanh(e / (2 + e)).
template <class real> PLIANT_INLINE real log_remainder(real e) {
  if (magnitude(e) > real(0.3)) return (e - log_of_one_plus(e)) / (e * e);
  const real half = 1 / (2 + e), z2 = e * e * half * half;
  real series = 0;
  for (int k = 14; k >= 1; --k) series = series * z2 + 1 / static_cast<real>(2 * k + 1);
  return half - 2 * e * series * half * half * half;
}

/// f' and f'' at s = 1 + e of a sum.
template <class real> struct Slopes { real first, second; };

template <class real> PLIANT_INLINE Slopes<real> basis_slopes(const Real4<real>* __restrict terms, real e) {
  const real low = real(STRETCH_LEAST) - 1, high = real(STRETCH_MOST) - 1;
  const real inside = e < low ? low : e > high ? high : e, s = 1 + inside, r = 1 / s;
  real first = 0, second = 0;
  for (int k = 0; k < STRETCH_POWERS && terms[k].x > 0; ++k) {
    const Real4<real> term = terms[k]; // n, A, B, log2
    const int n = static_cast<int>(term.x);
    if (n == 1 && term.y == 0 && term.w == 0) { // B_1: a spring
      first += 2 * term.z * inside;
      second += 2 * term.z;
      continue;
    }
    // s^n - 1 = e p_n(s) and 1 - r^n = e r p_n(r), p_n(x) = 1 + x + .. + x^(n-1).
    real up = 1, down = 1, power = 1, inverse = r;
    for (int m = 1; m < n; ++m) {
      up = up * s + 1;
      down = down * r + 1;
      power *= s;
      inverse *= r;
    }
    first += inside / term.x * (term.y * (up + r * down) + 2 * term.z * up);
    second += term.y * (power + inverse * r) + 2 * term.z * power;
    if (term.w != 0) {
      const real l = log_of_one_plus(inside);
      first += 2 * term.w * l * r;
      second += 2 * term.w * (1 - l) * r * r;
    }
  }
  return {first + (e - inside) * second, second};
}

template <class real> PLIANT_INLINE real basis_value(const Real4<real>* __restrict terms, real e) {
  const real low = real(STRETCH_LEAST) - 1, high = real(STRETCH_MOST) - 1;
  const real inside = e < low ? low : e > high ? high : e, s = 1 + inside, r = 1 / s;
  real sum = 0; // over e^2
  for (int k = 0; k < STRETCH_POWERS && terms[k].x > 0; ++k) {
    const Real4<real> term = terms[k];
    const int n = static_cast<int>(term.x);
    // B_n = 2 e^2 q_n(s) / (n (n + 1)), A_n = e^2 / n (r + q_n(s) / (n + 1) + r^2 q_n-2(r) / (n - 1)) with
    // q_n = p_1 + .. + p_n.
    real up = 0, down = 0, sum_up = 0, sum_down = 0;
    for (int m = 1; m <= n; ++m) {
      up = up * s + 1;
      sum_up += up;
      down = down * r + 1;
      if (m + 2 <= n) sum_down += down;
    }
    const real over = sum_up / (term.x + 1);
    if (term.y != 0)
      sum += term.y * (n == 1 ? real(0.5) + log_remainder(inside)
                              : (r + over + r * r * sum_down / (term.x - 1)) / term.x);
    sum += 2 * term.z * over / term.x;
    if (term.w != 0 && inside != 0) {
      const real ratio = log_of_one_plus(inside) / inside;
      sum += term.w * ratio * ratio;
    } else {
      sum += term.w;
    }
  }
  const real beyond = e - inside;
  if (beyond == 0) return inside * inside * sum;
  const Slopes<real> slope = basis_slopes(terms, inside);
  return inside * inside * sum + beyond * (slope.first + beyond * slope.second / 2);
}

/// The dilatation less one from what bonds lengthen by, over the neighbourhood's modulus: the mean stretch,
/// or the root of the mean square from half the mean square less one.
template <class real> PLIANT_INLINE real dilatation_of(real mean, bool squared) {
  if (!squared) return mean;
  const real square = 1 + 2 * mean;
  return 2 * mean / (1 + root(square > 0 ? square : 0));
}

/// What one bond adds to that, m2, of its lengths now and at rest.
template <class real> PLIANT_INLINE real lengthening_of(real size, real x, bool squared) {
  return squared ? (size - x) * (size + x) / 2 : (size - x) * x;
}

/// for_each_bond() with the strengths by direction, visit(j, xi, c_out, c_in, g_out, g_in): 1 without.
template <class View, class Visit>
PLIANT_INLINE void for_each_bond_of_strength(const View& k, uint local, Visit visit) {
  using real = typename View::real;
  const uint slice = k.first_slice + local / 16, lane = local % 16;
  for (uint row = k.slice_begin[slice]; row < k.slice_begin[slice + 1]; ++row) {
    const std::size_t entry = std::size_t{32} * row + lane;
    visit(k.bond[entry], unpack_bond(k.bond[entry + 16], k.unit), k.weight[entry], k.weight[entry + 16],
          k.anisotropic ? k.strength[entry] : real(1), k.anisotropic ? k.strength[entry + 16] : real(1));
  }
}

} // namespace pliant::openmp::PLIANT_ISA
