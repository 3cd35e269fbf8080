// From a material's law, shares and constants to its energy over bond stretches.
#include "engine/model/stretch_energy.h"

#include "engine/core/error.h"
#include "engine/model/anisotropy.h"
#include "engine/model/model.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace pliant {

namespace {

/// Stretches at which curvatures are looked at, from the least to the largest, finest near rest.
template <class Visit> void for_each_stretch(Visit visit) {
  constexpr int points = 400;
  for (int k = 0; k <= points; ++k)
    visit(smallest_stretch * std::pow(largest_stretch / smallest_stretch, double(k) / points));
}

/// Where f'' > 0 around s = 1, in words.
std::string convex_range(const BasisSum& sum) {
  if (!(sum.second(1) > 0)) return "it is not convex at rest";
  double low = 0, high = HUGE_VAL;
  for_each_stretch([&](double s) {
    if (sum.second(s) > 0) return;
    if (s < 1) low = std::max(low, s);
    if (s > 1) high = std::min(high, s);
  });
  if (low == 0 && high == HUGE_VAL)
    return "this sum is convex all the same: write it without negative shares";
  if (high == HUGE_VAL) return fmt::format("this sum is convex for stretches above {:.2f} only", low);
  if (low == 0) return fmt::format("this sum is convex for stretches below {:.2f} only", high);
  return fmt::format("this sum is convex for stretches of {:.2f} to {:.2f} only", low, high);
}

/// lambda_2 / mu_2 of the ratio given.
double coupling_of(const Material& material, Neighbourhood neighbourhood, double poisson) {
  Material other = material;
  other.poisson = poisson;
  return law_constants(other, neighbourhood).coupling;
}

/// W is at least F(theta) = (lambda_2 / mu_2) g(theta) + h(theta) / <1/G>, by Jensen's inequality: where F is
/// convex, rest is the least state. Only a negative lambda_2 can spoil that.
bool least_at_rest(const BasisSum& g, const BasisSum& h, double coupling, double softness) {
  bool good = true;
  for_each_stretch([&](double s) { good = good && coupling * g.second(s) + h.second(s) / softness > 0; });
  return good;
}

/// <1/G> of a material's bonds; of a sheet that lies as it may, the most.
double softness_of(const Material& material, Neighbourhood neighbourhood) {
  const Vector3& strengths = material.anisotropy.strengths;
  if (!material.anisotropy.given) return 1;
  return neighbourhood == Neighbourhood::solid ? mean_softness(strengths)
                                               : mean_softness(strengths.minCoeff(), strengths.maxCoeff());
}

void check_least_at_rest(const Material& material, Neighbourhood neighbourhood, const BasisSum& g,
                         const BasisSum& h) {
  const double softness = softness_of(material, neighbourhood);
  if (least_at_rest(g, h, coupling_of(material, neighbourhood, material.poisson), softness)) return;
  const double even = neighbourhood == Neighbourhood::plane_stress ? 1. / 3 : 0.25; // where lambda_2 = 0
  double low = material.poisson, high = even;
  if (coupling_of(material, neighbourhood, high) < -1e-12) high = 0.499;
  while (high - low > 1e-4) {
    const double middle = (low + high) / 2;
    (least_at_rest(g, h, coupling_of(material, neighbourhood, middle), softness) ? high : low) = middle;
  }
  throw Error(
      ExitCode::usage,
      fmt::format("with a Poisson's ratio of {} the energy is not convex: lambda_2 is negative below {:.4g}, "
                  "and outweighs mu_2 at some stretch; with this g{} and h it is convex for ratios of "
                  "{:.3f} upwards{}",
                  material.poisson, even, material.anisotropy.given ? ", these strengths" : "",
                  std::ceil(high * 1000) / 1000,
                  material.anisotropy.given ? "" : ", and with g equal to h for all"));
}

} // namespace

BasisSum basis_sum(const std::map<std::string, double>& shares) {
  BasisSum sum;
  std::set<int> powers;
  for (const auto& [name, share] : shares) {
    BasisTerm term = parse_basis(name);
    term.share = share;
    if (share != 0) powers.insert(term.n);
    if (share != 0) sum.terms.push_back(term);
  }
  for (const BasisTerm& term : sum.terms)
    if (!(term.share > 0))
      throw Error(
          ExitCode::usage,
          fmt::format("the share of {} is {}; shares must not be negative, because every basis function is "
                      "convex and a difference need not be: {}. (St. Venant-Kirchhoff's (3 B3 - B1) / 2 is "
                      "law = \"stvk\")",
                      basis_name(term), term.share, convex_range(sum)));
  if (!(sum.total() > 0))
    throw Error(ExitCode::usage, "the shares sum to nothing; give at least one, such as { B1 = 1.0 }");
  if (powers.size() > largest_powers)
    throw Error(ExitCode::usage,
                fmt::format("{} different powers n are more than the {} that kernels hold; A and B "
                            "of one n count once",
                            powers.size(), largest_powers));
  return sum.normalised();
}

StretchEnergy stretch_energy(const Material& material, Neighbourhood neighbourhood) {
  StretchEnergy energy;
  if (law_of(material) != Law::basis) return energy;
  const double coupling = law_constants(material, neighbourhood).coupling;
  if (material.law == "stvk") {
    energy.bond = saint_venant_kirchhoff_basis();
    energy.volume = energy.bond.scaled(coupling);
    energy.squared = material.form != "bonds";
  } else if (material.law == "neo-hookean") {
    // (lambda_2 + part mu_2) / mu_2 = part lambda / mu_L, see law_constants().
    const double part = neighbourhood == Neighbourhood::solid ? 0.6 : 0.5;
    energy.bond.terms = {{BasisTerm::Kind::A, 1, 1.0}};
    energy.volume.terms = {{BasisTerm::Kind::log2, 1, coupling + part}, {BasisTerm::Kind::A, 1, -part}};
  } else {
    const BasisSum g = basis_sum(material.volume_basis);
    energy.bond = basis_sum(material.bond_basis);
    energy.volume = g.scaled(coupling);
    check_least_at_rest(material, neighbourhood, g, energy.bond);
    return energy;
  }
  if (material.anisotropy.given && !(coupling + 1 / softness_of(material, neighbourhood) > 0))
    throw Error(
        ExitCode::usage,
        fmt::format("with a Poisson's ratio of {} and these strengths the energy is not convex at rest; "
                    "choose a ratio nearer to 0.25, or strengths nearer to one another",
                    material.poisson));
  return energy;
}

SmallStrain small_strain(const Material& material) {
  const double nu = material.poisson;
  if (material.calibration != "xu2018") return {material.young, nu};
  return {material.young * (5 - 4 * nu) / (4 * (1 - nu) * (1 + nu)), 1 / (4 * (1 - nu))};
}

} // namespace pliant
