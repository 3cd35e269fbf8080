// The energy of law "basis" (Xu et al. 2018, Eqs. 12 and 14), over a particle's volume, in units of mu_2:
//
//   W / mu_2 = (lambda_2 / mu_2) g(theta) + <G h(s)>
//
// s is the stretch of a bond, <> the average over a neighbourhood, theta = <s>, or the root of <s^2>: with it
// the St. Venant-Kirchhoff law is exact for every homogeneous deformation, since the strain of a bond of
// direction N is N . E N = (s^2 - 1) / 2, whose average is tr E / 3.
#pragma once

#include "engine/model/basis.h"

#include <cstdint>
#include <map>

namespace pliant {

struct Material;

/// What the neighbours of a particle fill: a ball, or a disc of matter that can (stress) or cannot (strain)
/// thicken freely across it. Sheets are in plane stress.
enum class Neighbourhood : std::uint8_t { solid, plane_strain, plane_stress };

/// Of one material.
struct StretchEnergy {
  BasisSum volume;      ///< (lambda_2 / mu_2) g: f''(1) = 2 lambda_2 / mu_2
  BasisSum bond;        ///< h: f''(1) = 2
  bool squared = false; ///< theta is the root of the mean square stretch
};

/// The sum that shares by name stand for, normalised. Throws Error(usage): names that are none, shares that
/// are negative (saying where the sum would be convex) or sum to nothing, more powers than kernels hold.
BasisSum basis_sum(const std::map<std::string, double>& shares);

/// Of a material, in solids or in what is flat, whose law is "basis", "stvk", or "neo-hookean" with form
/// "bonds"; empty sums for the others. Throws Error(usage): what basis_sum() throws, and energies that are
/// not convex because lambda_2 is negative.
///   neo-hookean, bonds: h = A_1, (lambda_2 / mu_2) g = 3/5 ((lambda_L / mu_L) log2 - A_1), which is exact
///   for dilation and small strain; in two dimensions 1/2 (...), with lambda' of law_constants().
StretchEnergy stretch_energy(const Material& material, Neighbourhood neighbourhood = Neighbourhood::solid);

/// Powers n that a sum may hold: the kernels' table has so many rows for it.
inline constexpr int largest_powers = 4;

/// What a small strain of the material returns: what was typed, or with calibration "xu2018" (Eq. 26, whose
/// lambda_2 lacks -(9/2) mu_L) nu = 1 / (4 (1 - nu_typed)) and E = E_typed (5 - 4 nu) / (4 (1 - nu) (1 +
/// nu)).
struct SmallStrain {
  double young = 0, poisson = 0; ///< Pa
};
SmallStrain small_strain(const Material& material);

} // namespace pliant
