// A mesh as it is drawn: each vertex once for every smooth patch around it, so that an edge of a box stays
// sharp.
#pragma once

#include "engine/scene/mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace pliant::gl {

struct DrawnMesh {
  /// A corner: the vertex of the mesh, then first and last (not included) of its triangles in `fans`.
  std::vector<std::array<std::uint32_t, 4>> corners;
  std::vector<std::uint32_t> fans;                     ///< triangles over which a corner is smooth
  std::vector<std::array<std::uint32_t, 3>> triangles; ///< of vertices of the mesh
  std::vector<std::array<std::uint32_t, 3>> indices;   ///< of corners
};

/// Two triangles that share an edge are smooth where they meet at less than `degrees`.
DrawnMesh split_creases(const Mesh& mesh, double degrees = 50);

} // namespace pliant::gl
