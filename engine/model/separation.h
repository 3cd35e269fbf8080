// What it takes to part a material: two halves of a lattice, cut by a plane, moved apart along its normal as
// rigid bodies, slowly, until their last bonds break.
//
//     x x x x   <- moves along n          x x x x
//     x x x x   bonds across: |Y| grows   x x x x      all that cross are longer than they bear:
//    ---------  until (1 + s0) |xi|      ---------     the half-bodies are free, and what the bonds held
//     x x x x                             x x x x      when they broke is the energy of the crack
//     x x x x                             x x x x
//
// A bond takes with it what the neighbourhoods at its ends hold more with it than without: with the law's own
// energy, dilatation and rotation included, and broken bonds counted as unstretched. Where bonds bear by
// their length alone this is Silling and Askari's (2005) sum, b s0^2 <|xi . n|>; for other ratios than 1/4
// (1/3 in plane stress) the dilatation takes part; and bonds of the corotated law bear shear as well, which
// one that crosses aslant has most of when it breaks.
#pragma once

#include "engine/model/energy_density.h"

namespace pliant {

class Separation {
public:
  /// `bonds` in m, of a particle deep inside. Throws Error(internal) for laws whose bonds do not break.
  Separation(Law law, const LawConstants& constants, const StretchEnergy& energy, BondSet bonds);

  /// J/m2, where bonds break at this stretch less one, parted along a unit normal.
  double work(double stretch, const Vector3& normal) const;
  /// The stretch less one at which the mean work over the normals is `energy`, J/m2.
  double critical_stretch(double energy, const std::vector<Vector3>& normals) const;

private:
  double half(double stretch, const Vector3& normal) const;
  double density(const std::vector<Vector3>& y, const std::vector<char>& whole) const;

  Law law_;
  LawConstants constants_;
  StretchEnergy energy_;
  BondSet bonds_;
};

} // namespace pliant
