// Sums of basis functions for a part of a slice at once, where all its particles and their neighbours are of
// one material: `shape` and what is made of it marks such particles by half a row.
#pragma once

#include "backends/openmp/basis.h"
#include "backends/openmp/bond_wide.h"

namespace pliant::openmp::PLIANT_ISA {

/// Whether a part may be worked off at once, from its lanes' rows in the table.
template <class real> PLIANT_INLINE bool alike(Wide<real> rows) {
  const real first = rows[0];
  if (first == static_cast<real>(static_cast<uint>(first))) return false;
  return bits<real>(rows != spread(first)) == 0;
}

template <class real> struct WideSlopes { Wide<real> first, second; };

template <class real>
PLIANT_INLINE WideSlopes<real> basis_slopes(const Real4<real>* __restrict terms, Wide<real> e) {
  const Wide<real> none{}, low = none + (real(STRETCH_LEAST) - 1), high = none + (real(STRETCH_MOST) - 1);
  const Wide<real> above = e < low ? low : e, inside = above > high ? high : above;
  const Wide<real> s = 1 + inside, r = 1 / s;
  Wide<real> first{}, second{};
  for (int k = 0; k < STRETCH_POWERS && terms[k].x > 0; ++k) {
    const Real4<real> term = terms[k]; // n, A, B, log2
    const int n = static_cast<int>(term.x);
    Wide<real> up = none + 1, down = up, power = up, inverse = r;
    for (int m = 1; m < n; ++m) {
      up = up * s + 1;
      power *= s;
      if (term.y == 0) continue;
      down = down * r + 1;
      inverse *= r;
    }
    first += inside * ((2 * term.z / term.x) * up);
    second += (2 * term.z) * power;
    if (term.y != 0) {
      first += inside * ((term.y / term.x) * (up + r * down));
      second += term.y * (power + inverse * r);
    }
    if (term.w != 0) {
      Wide<real> l = inside;
      for (uint lane = 0; lane < lanes<real>; ++lane) l[lane] = log_of_one_plus(l[lane]);
      first += (2 * term.w) * l * r;
      second += (2 * term.w) * (1 - l) * r * r;
    }
  }
  return {first + (e - inside) * second, second};
}

/// log_remainder() of every lane: the series where it holds, which it does nearly everywhere.
template <class real> PLIANT_INLINE Wide<real> log_remainder_wide(Wide<real> e) {
  constexpr int terms = sizeof(real) == 4 ? 6 : 14; // z^2 < .032, so that what follows is below a rounding
  const Wide<real> half = 1 / (2 + e), z2 = e * e * half * half;
  Wide<real> series{};
  for (int k = terms; k >= 1; --k) series = series * z2 + 1 / static_cast<real>(2 * k + 1);
  Wide<real> value = half - 2 * e * series * half * half * half;
  const uint far = bits<real>(magnitudes<real>(e) > real(0.3));
  for (uint lane = 0; far >> lane != 0; ++lane)
    if (far >> lane & 1u) value[lane] = log_remainder<real>(e[lane]);
  return value;
}

template <class real>
PLIANT_INLINE Wide<real> basis_value(const Real4<real>* __restrict terms, Wide<real> e) {
  const Wide<real> none{}, low = none + (real(STRETCH_LEAST) - 1), high = none + (real(STRETCH_MOST) - 1);
  const Wide<real> above = e < low ? low : e, inside = above > high ? high : above;
  const Wide<real> s = 1 + inside, r = 1 / s;
  Wide<real> sum{}; // over e^2
  for (int k = 0; k < STRETCH_POWERS && terms[k].x > 0; ++k) {
    const Real4<real> term = terms[k]; // n, A, B, log2
    const int n = static_cast<int>(term.x);
    Wide<real> up{}, sum_up{}, down{}, sum_down{};
    for (int m = 1; m <= n; ++m) {
      up = up * s + 1;
      sum_up += up;
      if (term.y == 0 || m + 2 > n) continue;
      down = down * r + 1;
      sum_down += down;
    }
    const Wide<real> over = sum_up * (1 / (term.x + 1));
    if (term.y != 0 && n == 1) sum += term.y * (real(0.5) + log_remainder_wide<real>(inside));
    if (term.y != 0 && n > 1) sum += (term.y / term.x) * (r + over + r * r * sum_down * (1 / (term.x - 1)));
    if (term.z != 0) sum += (2 * term.z / term.x) * over;
    if (term.w != 0) {
      Wide<real> ratio = none + 1;
      for (uint lane = 0; lane < lanes<real>; ++lane)
        if (inside[lane] != 0) ratio[lane] = log_of_one_plus(inside[lane]) / inside[lane];
      sum += term.w * ratio * ratio;
    }
  }
  Wide<real> value = inside * inside * sum;
  const Wide<real> beyond = e - inside;
  if (bits<real>(beyond != 0) != 0) {
    const WideSlopes<real> slope = basis_slopes<real>(terms, inside);
    value += beyond * (slope.first + beyond * slope.second / 2);
  }
  return value;
}

/// A sum's terms with what divides them, for many stretches.
template <class real> struct BasisTerms {
  const Real4<real>* rows;
  uint count = 0;
  int n[STRETCH_POWERS];
  real a[STRETCH_POWERS], b[STRETCH_POWERS], over[STRETCH_POWERS], under[STRETCH_POWERS];

  PLIANT_INLINE explicit BasisTerms(const Real4<real>* terms) : rows(terms) {
    for (; count < STRETCH_POWERS && terms[count].x > 0; ++count) {
      const Real4<real> term = terms[count];
      n[count] = static_cast<int>(term.x);
      a[count] = term.y / term.x;
      b[count] = 2 * term.z / term.x;
      over[count] = 1 / (term.x + 1);
      under[count] = term.x > 1 ? 1 / (term.x - 1) : 0;
    }
  }
};

/// basis_slopes().first and, with `valued`, basis_value() in one pass; as they are where a lane lies beyond
/// the limits.
template <class real> struct WideBasis { Wide<real> slope, value; };
template <bool valued, class real>
PLIANT_INLINE WideBasis<real> basis_at(const BasisTerms<real>& terms, Wide<real> e) {
  const Wide<real> none{}, low = none + (real(STRETCH_LEAST) - 1), high = none + (real(STRETCH_MOST) - 1);
  if (bits<real>(e < low) != 0 || bits<real>(e > high) != 0)
    return {basis_slopes<real>(terms.rows, e).first, valued ? basis_value<real>(terms.rows, e) : none};
  const Wide<real> s = 1 + e, r = 1 / s;
  Wide<real> slope{}, value{};
  for (uint k = 0; k < terms.count; ++k) {
    const Real4<real> term = terms.rows[k]; // n, A, B, log2
    const int n = terms.n[k];
    Wide<real> up = none + 1, sum_up = up, down = up, sum_down = n > 2 ? up : none;
    for (int m = 2; m <= n; ++m) {
      up = up * s + 1;
      sum_up += up;
      if (term.y == 0) continue;
      down = down * r + 1;
      if (m + 2 <= n) sum_down += down;
    }
    slope += e * (terms.b[k] * up);
    if (term.y != 0) slope += e * (terms.a[k] * (up + r * down));
    if (term.w != 0) {
      Wide<real> l = e;
      for (uint lane = 0; lane < lanes<real>; ++lane) l[lane] = log_of_one_plus(l[lane]);
      slope += (2 * term.w) * l * r;
    }
    if (!valued) continue;
    const Wide<real> over = sum_up * terms.over[k];
    if (term.y != 0 && n == 1) value += term.y * (real(0.5) + log_remainder_wide<real>(e));
    if (term.y != 0 && n > 1) value += terms.a[k] * (r + over + r * r * sum_down * terms.under[k]);
    if (term.z != 0) value += terms.b[k] * over;
    if (term.w != 0) {
      Wide<real> ratio = none + 1;
      for (uint lane = 0; lane < lanes<real>; ++lane)
        if (e[lane] != 0) ratio[lane] = log_of_one_plus(e[lane]) / e[lane];
      value += term.w * ratio * ratio;
    }
  }
  return {slope, e * e * value};
}

/// What one bond adds to the dilatation, and the dilatation from the mean: see basis.h.
template <class real>
PLIANT_INLINE Wide<real> lengthening_of(const Wide<real>& size, const Wide<real>& x, bool squared) {
  return (size - x) * (squared ? (size + x) / 2 : x);
}
template <class real> PLIANT_INLINE Wide<real> dilatation_of(const Wide<real>& mean, bool squared) {
  if (!squared) return mean;
  const Wide<real> square = 1 + 2 * mean, none{};
  return 2 * mean / (1 + root_wide<real>(square > 0 ? square : none));
}

/// for_each_bond_of_part() with the strengths by direction, visit(j, xi, c_out, c_in, g_out, g_in).
template <class View, class Visit>
PLIANT_INLINE void for_each_bond_of_strength_of_part(const View& k, uint local, Visit visit) {
  using real = typename View::real;
  const uint slice = k.first_slice + local / 16, lane = local % 16;
  const Wide<real> one = Wide<real>{} + 1;
  for (std::size_t row = k.slice_begin[slice], end = k.slice_begin[slice + 1]; row < end; ++row) {
    const std::size_t at = 32 * row + lane;
    const Wide3<real> xi = unpack_bonds<real>(load_words<real>(k.bond + at + 16));
    visit(k.bond + at, xi, load_wide(k.weight + at), load_wide(k.weight + at + 16),
          k.anisotropic ? load_wide(k.strength + at) : one,
          k.anisotropic ? load_wide(k.strength + at + 16) : one);
  }
}

} // namespace pliant::openmp::PLIANT_ISA
