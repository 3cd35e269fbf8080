// The shape tensor of a reference neighbourhood, K = sum_j omega_ij xi (x) xi / x^2: what turns <Y (x) xi /
// x^2> into a deformation gradient. With weights matched to the second moments it is one third of the
// identity.
#pragma once

#include "engine/model/model.h"

namespace pliant {

struct ShapeTensor {
  Matrix3 inverse = Matrix3::Zero(); ///< dimensionless; a pseudo-inverse where the rank is below 3
  int rank = 0;                      ///< 3 solid, 2 all bonds in a plane, 1 along a line, 0 no bonds
  double least = 0;                  ///< smallest eigenvalue of K that counts
};

/// Eigenvalues below this share of their sum count as none: a plane of particles that is not quite flat has
/// 1e-4, a solid lattice's corner with plain weights 0.1.
inline constexpr double shape_cutoff = 1e-3;

/// Of particle i.
ShapeTensor shape_tensor(const Model& model, std::uint32_t i);

/// Laws that need a deformation gradient in all three directions: throws Error(usage) for a body of such a
/// law with particles whose bonds lie in a plane or along a line. Particles without bonds fly free.
void require_solid(const Scene& scene, const Model& model);

/// Six of a symmetric matrix, in the order xx xy xz yy yz zz.
inline std::array<double, 6> symmetric_six(const Matrix3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

} // namespace pliant
