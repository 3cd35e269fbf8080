// Values and derivatives of the basis functions, written in e = s - 1 so that nothing cancels near rest.
#include "engine/model/basis.h"

#include "engine/core/error.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace pliant {

namespace {

using Kind = BasisTerm::Kind;

/// p_n(x) = 1 + x + ... + x^(n-1), so that x^n - 1 = (x - 1) p_n(x).
double geometric(double x, int n) {
  double sum = 0;
  for (int k = 0; k < n; ++k) sum = sum * x + 1;
  return sum;
}

/// q_n(x) = p_1(x) + ... + p_n(x), so that p_n+1(x) - (n + 1) = (x - 1) q_n(x).
double summed(double x, int n) {
  double sum = 0;
  for (int k = 1; k <= n; ++k) sum += geometric(x, k);
  return sum;
}

/// (e - ln(1 + e)) / e^2, which is 1/2 at e = 0.
double logarithm_remainder(double e) {
  if (std::abs(e) > 0.2) return (e - std::log1p(e)) / (e * e);
  // ln(1 + e) = 2 artanh z with z = e / (2 + e), hence e - ln(1 + e) = e z - 2 z^3 (1/3 + z^2/5 + ...).
  const double ratio = 1 / (2 + e), z2 = e * e * ratio * ratio;
  double series = 0;
  for (int k = 12; k >= 1; --k) series = series * z2 + 1.0 / (2 * k + 1);
  return ratio - 2 * e * series * ratio * ratio * ratio;
}

double term_value(const BasisTerm& term, double e) {
  const double s = 1 + e, n = term.n;
  if (term.kind == Kind::log2) {
    const double l = std::log1p(e);
    return l * l;
  }
  if (term.kind == Kind::B) return 2 * e * e * summed(s, term.n) / (n * (n + 1));
  if (term.n == 1) return e * e * (0.5 + logarithm_remainder(e));
  const double r = 1 / s;
  return e * e / n * (r + summed(s, term.n) / (n + 1) + r * r * summed(r, term.n - 2) / (n - 1));
}

double term_first(const BasisTerm& term, double e) {
  const double s = 1 + e, r = 1 / s, n = term.n;
  if (term.kind == Kind::log2) return 2 * std::log1p(e) * r;
  if (term.kind == Kind::B) return 2 * e * geometric(s, term.n) / n;
  return e * (geometric(s, term.n) + r * geometric(r, term.n)) / n;
}

double term_second(const BasisTerm& term, double e) {
  const double s = 1 + e, r = 1 / s;
  if (term.kind == Kind::log2) return 2 * (1 - std::log1p(e)) * r * r;
  const double power = std::pow(s, term.n - 1);
  return term.kind == Kind::B ? 2 * power : power + std::pow(r, term.n + 1);
}

template <class Function> double sum_of(const BasisSum& basis, double e, Function function) {
  double sum = 0;
  for (const BasisTerm& term : basis.terms) sum += term.share * function(term, e);
  return sum;
}

struct Place {
  double inside, beyond; ///< e within the formulas' range, and how much further it is
};
Place place_of(double s) {
  const double inside = std::clamp(s, smallest_stretch, largest_stretch);
  return {inside - 1, s - inside};
}

} // namespace

double BasisSum::value(double s) const {
  const Place at = place_of(s);
  const double inside = sum_of(*this, at.inside, term_value);
  if (at.beyond == 0) return inside;
  return inside + at.beyond * (sum_of(*this, at.inside, term_first) +
                               at.beyond / 2 * sum_of(*this, at.inside, term_second));
}

double BasisSum::first(double s) const {
  const Place at = place_of(s);
  const double inside = sum_of(*this, at.inside, term_first);
  return at.beyond == 0 ? inside : inside + at.beyond * sum_of(*this, at.inside, term_second);
}

double BasisSum::second(double s) const {
  return sum_of(*this, place_of(s).inside, term_second);
}

double BasisSum::total() const {
  double sum = 0;
  for (const BasisTerm& term : terms) sum += term.share;
  return sum;
}

BasisSum BasisSum::normalised() const {
  return scaled(1 / total());
}

BasisSum BasisSum::scaled(double factor) const {
  BasisSum result = *this;
  for (BasisTerm& term : result.terms) term.share *= factor;
  return result;
}

BasisTerm parse_basis(std::string_view name) {
  BasisTerm term;
  int n = 0;
  const bool known = !name.empty() && (name[0] == 'A' || name[0] == 'B');
  const auto [end, failure] = known ? std::from_chars(name.data() + 1, name.data() + name.size(), n)
                                    : std::from_chars_result{name.data(), std::errc::invalid_argument};
  if (!known || failure != std::errc{} || end != name.data() + name.size() || name[1] == '0' || n < 1)
    throw Error(ExitCode::usage,
                fmt::format("there is no basis function \"{}\"; they are A1 to A{} and B1 to B{}", name,
                            largest_power, largest_power));
  if (n > largest_power)
    throw Error(ExitCode::usage,
                fmt::format("the basis function \"{}\" is of a higher power than kernels hold; "
                            "they are A1 to A{} and B1 to B{}",
                            name, largest_power, largest_power));
  term.kind = name[0] == 'A' ? Kind::A : Kind::B;
  term.n = n;
  return term;
}

std::string basis_name(const BasisTerm& term) {
  if (term.kind == Kind::log2) return "log2";
  return fmt::format("{}{}", term.kind == Kind::A ? 'A' : 'B', term.n);
}

BasisSum saint_venant_kirchhoff_basis() {
  return {{{Kind::B, 3, 1.5}, {Kind::B, 1, -0.5}}};
}

} // namespace pliant
