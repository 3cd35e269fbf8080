// Triangle meshes: reading, checking, measuring, and telling inside from outside.
#pragma once

#include "engine/scene/scene.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace pliant {

struct Mesh {
  std::vector<Vector3> vertices;                       ///< m
  std::vector<std::array<std::uint32_t, 3>> triangles; ///< counter-clockwise from outside
};

/// Reads OBJ, OFF, PLY (ASCII and binary) or STL (ASCII and binary; equal corners are merged), polygons as
/// fans. Throws Error(usage) naming the file and line or byte: missing, empty, malformed, non-finite, index
/// out of range.
Mesh read_mesh(const std::filesystem::path& file);
/// Writes by extension: OBJ, OFF, PLY (binary), STL (binary). Throws Error(input_output).
void write_mesh(const Mesh& mesh, const std::filesystem::path& file);

/// Where meshes are sought, in this order: the scene's folder, $PLIANT_MESHES, the user's cache.
std::vector<std::filesystem::path> mesh_folders(const std::filesystem::path& scene_directory);
/// Where a mesh named in a scene lies: beside the scene, in $PLIANT_MESHES, in the user's cache. Throws
/// Error(usage) listing the places looked at and the command that fetches the meshes.
std::filesystem::path find_mesh(const std::string& name, const std::filesystem::path& scene_directory);

struct MeshReport {
  std::size_t open_edges = 0;     ///< edges with one triangle
  std::size_t odd_edges = 0;      ///< edges with more than two triangles, or two of the same direction
  std::size_t degenerate = 0;     ///< triangles of no area
  std::size_t crossing_pairs = 0; ///< pairs of triangles that cross
  double volume = 0;              ///< m3, signed
  double area = 0;                ///< m2
  Vector3 low = Vector3::Zero(), high = Vector3::Zero();
};
MeshReport examine(const Mesh& mesh);

/// Answers queries about one mesh through a tree over its triangles.
class MeshQuery {
public:
  explicit MeshQuery(const Mesh& mesh);
  ~MeshQuery();
  MeshQuery(MeshQuery&&) noexcept;
  /// Generalised winding number (Jacobson et al. 2013; tree of dipoles after Barill et al. 2018): 1 inside, 0
  /// outside. Nodes further away than `beta` of their radii count as dipoles: 4 keeps the error below 1e-3,
  /// 2 below 1e-2, which does for a sign.
  double winding_number(const Vector3& point, double beta = 4) const;
  /// Distance to the surface, m, unsigned; and the nearest point.
  double distance(const Vector3& point, Vector3* nearest = nullptr) const;

private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

} // namespace pliant
