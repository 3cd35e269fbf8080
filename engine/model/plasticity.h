// Drucker-Prager plasticity on law M2 (He, Wang and Wu 2017, section 5): what a neighbourhood bears, in the
// averages over its bonds in which the law is written, e_iso = <e> and <e_dev^2> = <(e - e_iso)^2>.
//
// In three dimensions e_iso = tr(strain) / 3 and <e_dev^2> = (2/15) of the deviatoric strain squared, so that
//
//   sqrt(J2) = sqrt(15) mu <e_dev^2>^(1/2)  <=  A - B tr(stress),   tr(stress) = 9 K e_iso, tension positive
//   A = 6 c cos(phi) / (sqrt(3) (3 + sin(phi))),   B = 2 sin(phi) / (sqrt(3) (3 + sin(phi)))
//
// the cone through the inner corners of Mohr and Coulomb's pyramid, c the cohesion in Pa: strength A in
// shear, A / (1/sqrt(3) + B) in tension, A / (1/sqrt(3) - B) in compression; the apex is at the mean stress
// c cot(phi). No friction is von Mises with a yield stress of 2 c. (The paper's Eq. 17 lacks the factors and
// the square of mu, and its Eq. 18 ends its root too late.)
// In plane strain Mohr and Coulomb's criterion itself:
//
//   2 sqrt(2) mu <e_dev^2>^(1/2)  <=  c cos(phi) - 2 (lambda + mu) e_iso sin(phi)
//
// Flow keeps the pressure (no dilatancy) until the apex. The cohesion may rise in proportion to the
// equivalent plastic strain, the integral of sqrt(2/3 d:d), d the rate of deviatoric flow.
#pragma once

#include "engine/model/model.h"

namespace pliant {

struct YieldSurface {
  double shear = 0;      ///< Pa: q of <e_dev^2> = 1
  double pressure = 0;   ///< Pa: by which what it bears falls with e_iso
  double strength = 0;   ///< Pa: what it bears at e_iso = 0
  double hardening = 0;  ///< Pa: by which that rises with the equivalent plastic strain
  double equivalent = 0; ///< equivalent strain of <e_dev^2> = 1
};
/// Throws Error(usage) for a plane stress, whose third strain the averages do not know, and for a friction
/// outside 0 to pi/2, a negative cohesion or hardening, or none that would bear anything.
YieldSurface yield_surface(const Material& material, Neighbourhood neighbourhood = Neighbourhood::solid);

/// Whether any particle is of a material that flows.
bool can_flow(const Scene& scene, const Model& model);

/// Of each particle; infinite strength where it does not flow. Throws Error(usage) as yield_surface() does,
/// for laws but "ordinary", and for materials that also break.
std::vector<YieldSurface> yield_surfaces(const Scene& scene, const Model& model);

} // namespace pliant
