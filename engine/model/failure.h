// When bonds break: the stretch that a material bears, and cuts that bodies have from the start.
#pragma once

#include "engine/model/model.h"

namespace pliant {

/// The stretch less one at which bonds break so that a crack takes `fracture_energy` (J/m2) a unit of area:
/// sqrt(G_c / (f b <|xi . n|>)), the energy of all bonds through the unit of area (Silling and Askari 2005,
/// on a finite set of neighbours). b is the ordinary law's bond modulus, Pa; <|xi . n|> (m) the mean reach of
/// a bond across the crack; f takes Poisson's ratio into account as Madenci and Oterkus (2014) do: 1 where
/// bonds alone carry (1/4; in plane stress 1/3).
double critical_stretch(double fracture_energy, double young, double poisson, double reach,
                        Neighbourhood neighbourhood = Neighbourhood::solid);

/// <|xi . n|> of a particle, m, with its weights: the mean over the normals of a lattice's planes (100),
/// (110) and (111), between which it varies by a few per cent; in what is flat, over all in its plane.
double crack_reach(const Model& model, std::uint32_t particle);

/// Whether any particle is of a material that breaks.
bool can_break(const Scene& scene, const Model& model);

/// Of each particle: the stretch less one at which its bonds break; infinite where they do not. A body's
/// fullest neighbourhood stands for the others. Throws Error(usage) for the projective law, whose shape
/// tensors do not know of broken bonds.
std::vector<double> critical_stretches(const Scene& scene, const Model& model);

/// Whether the segment from a to b meets a box (turned as `box` says). Throws Error(usage) for other shapes.
bool box_meets(const Shape& box, const Vector3& a, const Vector3& b);

} // namespace pliant
