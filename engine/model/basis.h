// One-dimensional basis functions of an elastic energy (Xu et al. 2018, Eqs. 15 to 17) of a stretch s > 0:
//
//   A_n = ((s^(n+1) - 1) / (n + 1) + (s^(1-n) - 1) / (n - 1)) / n     A_1 = (s^2 - 1) / 2 - ln s
//   B_n = 2 ((s^(n+1) - 1) / (n + 1) - s + 1) / n                     log2 = (ln s)^2
//
// All have f(1) = f'(1) = 0 and f''(1) = 2. A_n and B_n are convex for every s > 0, so every sum of them with
// shares that are not negative is; log2 is up to s = e only.
//
// Between smallest_stretch and largest_stretch the formulas hold; beyond, f' goes on in a straight line, so
// that a collapsed or a torn bond has a finite energy, still convex, whose powers fit single precision.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// Below it a repulsion that grows like s^-n would be infinite at s = 0; nothing an undamaged solid does
/// reaches it.
inline constexpr double smallest_stretch = 0.1;
/// Above it s^(n+1) would leave single precision.
inline constexpr double largest_stretch = 10;
/// Of n.
inline constexpr int largest_power = 8;

struct BasisTerm {
  enum class Kind : std::uint8_t { A, B, log2 };
  Kind kind = Kind::B;
  int n = 1; ///< 1 to largest_power; 1 for log2
  double share = 1;
};

/// A sum of basis functions with shares. Exact near s = 1, where the powers cancel, to the last few
/// roundings.
struct BasisSum {
  std::vector<BasisTerm> terms;

  double value(double s) const;
  double first(double s) const;  ///< d/ds
  double second(double s) const; ///< d2/ds2
  /// Sum of the shares: half of the second derivative at s = 1.
  double total() const;
  /// With shares that sum to one, so that the second derivative at s = 1 is 2. The total must not be zero.
  BasisSum normalised() const;
  /// Every share times a factor.
  BasisSum scaled(double factor) const;
};

/// "A4" or "B1": n from 1 to largest_power, share 1. Throws Error(usage) for other names, saying what would
/// do.
BasisTerm parse_basis(std::string_view name);
/// "A4", "B1", "log2".
std::string basis_name(const BasisTerm& term);

/// The one-dimensional energy (s^2 - 1)^2 / 4 = (3 B_3 - B_1) / 2 of the St. Venant-Kirchhoff law. Convex
/// for s > 0.577 only.
BasisSum saint_venant_kirchhoff_basis();

} // namespace pliant
