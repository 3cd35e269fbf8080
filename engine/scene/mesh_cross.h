// Which triangles of a mesh pass through each other, decided by exact signs.
#pragma once

#include "engine/scene/winding.h"

namespace pliant {

/// Sign of the volume of the tetrahedron a b c d: +1 where d lies below the plane of a, b, c seen
/// counter-clockwise. Exact: a filter in double first (Shewchuk 1997), then expansions.
int orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d);

/// Whether the insides of two triangles meet: not where they only touch at edges or corners. Triangles of no
/// area cross nothing.
bool triangles_cross(const Corners& p, const Corners& q);

/// examine() without the pairs of triangles that cross, which take the time.
MeshReport measure(const Mesh& mesh);
/// Pairs of triangles that cross and share no vertex (by number or by place).
std::size_t count_crossing_pairs(const Mesh& mesh);

} // namespace pliant
