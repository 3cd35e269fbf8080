// Fills a shape with particles at a spacing.
#pragma once

#include "engine/scene/mesh.h"

#include <optional>

namespace pliant {

struct Sampling {
  std::vector<Vector3> points; ///< m, world; a lattice aligned with the shape's own axes
  std::vector<Vector3>
      reference; ///< m, the same points in the shape's axes, relative to a lattice point near the centre
  Matrix3 axes = Matrix3::Identity(); ///< world = origin + axes * reference
  Vector3 origin = Vector3::Zero();
  double volume = 0;                 ///< m3, of the shape itself: the particles share it equally
  std::optional<Mesh> surface;       ///< world position; the mesh, or a triangulation of the analytic shape
  std::vector<std::string> warnings; ///< e.g. triangles that cross
};

/// Cell-centred lattice points inside the shape. A box whose edges are whole multiples of the spacing is
/// filled exactly. Order: z slowest, x fastest, in the shape's axes (a cylinder and a torus stand about their
/// own y). For meshes: where the winding number exceeds 1/2. Throws Error(usage) for open or empty meshes and
/// for shapes too small to hold a particle, Error(too_large) for more than 32 bits can number.
Sampling sample(const Shape& shape, double spacing, const std::filesystem::path& scene_directory);

/// One layer of particles over a sheet or a mesh, open or closed, `thickness` (m) thick; the volume is area
/// times thickness. Flat ones get a square lattice that is centred on them, curved ones points spread evenly
/// over them, about one to a square of the spacing, the same on every machine. Throws Error(usage) as
/// sample().
Sampling sample_sheet(const Shape& shape, double thickness, double spacing,
                      const std::filesystem::path& scene_directory);
/// The section of a box, sphere, cylinder or sheet with its own plane z = 0, `thickness` (m) deep.
Sampling sample_section(const Shape& shape, double thickness, double spacing,
                        const std::filesystem::path& scene_directory);

/// Whether a point lies in the shape; for regions and boundaries. Plane: on the side opposite to the normal.
/// Meshes may be open: the winding number closes their holes. Throws Error(usage) as place() of shape.h.
class ShapeQuery {
public:
  ShapeQuery(const Shape& shape, const std::filesystem::path& scene_directory);
  ~ShapeQuery();
  ShapeQuery(ShapeQuery&&) noexcept;
  bool contains(const Vector3& point) const;
  /// m; negative inside.
  double signed_distance(const Vector3& point) const;
  /// The surface in world position, as triangles (a plane: none).
  const Mesh& surface() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace pliant
