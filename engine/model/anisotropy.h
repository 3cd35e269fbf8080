// Stiffness of bonds by direction (Xu et al. 2018, Eq. 18, corrected):
//
//   G(N) = |Sigma R^T N| / <|Sigma R^T N|>,   N the direction of a bond at rest, <> the mean over the sphere
//                                           (of what is flat: over its circle)
//
// The columns of R are the material's directions, so that R^T N are the components of N along them; Sigma
// holds their strengths. Divided by its mean, G leaves the average stiffness alone, which strengths of
// product one do not. Particles may have directions of their own: radial, tangential and axial about an axis.
#pragma once

#include "engine/model/model.h"

namespace pliant {

/// <|Sigma N|> over the sphere. Strengths above 0.
double mean_strength(const Vector3& strengths);
/// <1/G> over the sphere, at least 1: how much softer bonds of unequal strength are to dilation that they
/// share as they like.
double mean_softness(const Vector3& strengths);
/// The same over a circle, of an ellipse with these half axes.
double mean_strength(double one, double other);
double mean_softness(double one, double other);

/// Rows: the three directions at a place, m, in the scene's axes. Throws Error(usage): strengths that are not
/// positive, directions that are not orthonormal.
Matrix3 directions_at(const Anisotropy& anisotropy, const Vector3& place);
/// G of a unit direction, given mean_strength().
double strength_along(const Vector3& direction, const Matrix3& directions, const Vector3& strengths,
                      double mean);

/// Throws Error(usage) as directions_at() does.
void check_anisotropy(const Anisotropy& anisotropy);

/// G_ij of every bond, by the material of its own particle; empty where no particle has a material with
/// directions. Throws Error(usage).
std::vector<double> bond_strengths(const Scene& scene, const Model& model);

} // namespace pliant
