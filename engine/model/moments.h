// Weights of one neighbourhood whose moments are those of an isotropic ball.
#pragma once

#include "engine/model/offset.h"

#include <span>

namespace pliant {

/// Of the moments that a law's small strains depend on: 2 where they come from a deformation gradient, 4
/// where from the stretches of bonds.
int moment_order(Law law);

struct NeighbourhoodWeights {
  std::vector<double> weight; ///< non-negative, sum 1; empty where there are no neighbours
  double residual = 0;        ///< of the moments, Frobenius norm relative to the target's
};

/// Normalised weights of the bond vectors, from the base influence.
/// `order` 2: second moments, sum w N N = I / 3. `order` 4: fourth, sum w N N N N = (dd + dd + dd) / 15.
/// `dimension` 2: I / 2 and (dd + dd + dd) / 8, of the bonds laid flat (keeping their lengths) into the plane
/// nearest to them. Where `matched`, the weights nearest to the base that meet the moments, or miss them
/// least; see moments.cpp.
NeighbourhoodWeights neighbourhood_weights(std::span<const GridVector> vectors, const Influence& influence,
                                           int order, bool matched, int dimension = 3);

} // namespace pliant
