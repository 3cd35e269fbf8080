// Which places may be near an obstacle, many at once: most are near none.
#pragma once

#include "backends/openmp/math.h"
#include "backends/openmp/simd.h"
#include "shaders/common/contact.glsl"

namespace pliant::openmp::PLIANT_ISA {

/// The largest of how far places lie beyond the faces of the box around an obstacle, in its own axes: no more
/// than its signed distance outside, and inside that of a box and, with `radial`, of what is round about its
/// y axis.
template <class real>
PLIANT_INLINE Wide<real> beyond_faces(const Real4<real>* axes, const Wide3<real>& from, Vec3<real> half,
                                      bool radial) {
  const auto own = [&](real Real4<real>::*c) -> Wide<real> {
    return from.x * axes[0].*c + from.y * axes[1].*c + from.z * axes[2].*c;
  };
  const auto larger_of = [](Wide<real> a, Wide<real> b) -> Wide<real> { return a > b ? a : b; };
  const Wide<real> x = own(&Real4<real>::x), y = magnitudes<real>(own(&Real4<real>::y)) - half.y,
                   z = own(&Real4<real>::z);
  if (radial) return larger_of(root_wide<real>(x * x + z * z) - half.x, y);
  return larger_of(larger_of(magnitudes<real>(x) - half.x, magnitudes<real>(z) - half.z), y);
}

/// Which places may be nearer than `least` to an obstacle; `from`: from its centre to them. A little more,
/// for rounding.
template <class real>
PLIANT_INLINE WideMask<real> may_touch(const Real4<real>* rows, const Wide3<real>& from, real least) {
  const auto traits = rows[OBSTACLE_KIND], place = rows[OBSTACLE_CENTRE], size = rows[OBSTACLE_SIZE];
  const auto* const axes = rows + OBSTACLE_AXES;
  const WideMask<real> near = dot(from, from) <= place.w * place.w;
  const bool container = traits.w > 0;
  const int kind = static_cast<int>(traits.x);
  real most = real(1.001) * least;
  if (kind == OBSTACLE_PLANE) {
    const Wide<real> along = from.x * axes[0].y + from.y * axes[1].y + from.z * axes[2].y;
    return near & ((container ? -along : along) < most);
  }
  Vec3<real> half{size.x, size.x, size.x}; // of a sphere
  if (kind == OBSTACLE_BOX) half = {size.x, size.y, size.z};
  if (kind == OBSTACLE_CYLINDER) half.y = size.y;
  if (kind == OBSTACLE_TORUS) half = {size.x + size.y, size.y, size.x + size.y};
  if (kind == OBSTACLE_MESH) half = {-axes[0].w, -axes[1].w, -axes[2].w};
  most +=
      real(1e-6) * (magnitude(place.x) + magnitude(place.y) + magnitude(place.z) + half.x + half.y + half.z);
  if (!container) return near & (beyond_faces(axes, from, half, kind == OBSTACLE_CYLINDER) < most);
  if (kind != OBSTACLE_BOX && kind != OBSTACLE_CYLINDER) return near;
  return near & (beyond_faces(axes, from, half, kind == OBSTACLE_CYLINDER) > -most);
}

} // namespace pliant::openmp::PLIANT_ISA
