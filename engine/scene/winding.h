// A tree of boxes over the triangles of a mesh, and the geometry of one triangle.
#pragma once

#include "engine/scene/mesh.h"

namespace pliant {

using Corners = std::array<Vector3, 3>;

/// Nodes in depth-first order: the first child of node i is i + 1, the second is `second`; 0 marks a leaf.
struct TriangleTree {
  struct Node {
    Vector3 low, high;
    std::uint32_t first = 0, count = 0; ///< triangles in tree order
    std::uint32_t second = 0;
  };
  std::vector<Node> nodes;
  std::vector<std::uint32_t> order; ///< triangle of the mesh by place in the tree
  std::vector<Corners> corners;     ///< in tree order

  /// Halves at the median of the centroids along the longest side. The same mesh gives the same tree.
  TriangleTree(const Mesh& mesh, std::uint32_t leaf_size);
};

/// Solid angle of a triangle seen from `point`, positive from behind (Van Oosterom & Strackee 1983), in
/// steradians.
double solid_angle(const Corners& triangle, const Vector3& point);

/// The point of the triangle that is nearest to `point`; triangles without area are fine.
Vector3 nearest_on_triangle(const Corners& triangle, const Vector3& point);

} // namespace pliant
