// A shape of the scene put in its place: centre, axes, size; how far a point is from it; its surface as
// triangles.
//
// In its own axes a shape is centred at the origin: a box along x, y, z; a cylinder and a torus about y; a
// mesh as in its file, after scaling, with the middle of its bounding box at the origin. World = centre +
// axes * own.
#pragma once

#include "engine/scene/mesh.h"

namespace pliant {

/// Accuracy of winding numbers that are only compared with 1/2: off by less than 1e-2.
constexpr double sign_beta = 2;

struct PlacedShape {
  Shape shape;
  Vector3 centre = Vector3::Zero();   ///< m, world
  Matrix3 axes = Matrix3::Identity(); ///< a rotation
  Vector3 half = Vector3::Zero();     ///< m; half the box in its own axes (a plane: zero)
  Mesh mesh;                          ///< mesh shapes: in own axes, triangles counter-clockwise from outside
  std::filesystem::path file;         ///< mesh shapes: where it was found
  bool turned = false;                ///< mesh shapes: the file's triangles faced inwards

  Vector3 to_own(const Vector3& world) const { return axes.transpose() * (world - centre); }
  Vector3 to_world(const Vector3& own) const { return centre + axes * own; }
};

/// Finds and reads the mesh, checks the sizes. Throws Error(usage): what read_mesh and find_mesh throw; sizes
/// that are not positive and finite; a torus whose tube is not thinner than its ring; a mesh without extent.
PlacedShape place(const Shape& shape, const std::filesystem::path& scene_directory);

/// "box", "mesh 'bunny.off'": for messages.
std::string name_of(const Shape& shape);

/// m3; of a mesh by the divergence theorem; of a plane 0.
double volume_of(const PlacedShape& placed);

/// Exact, m, negative inside, of a point in the shape's own axes. Not for meshes and planes.
double analytic_distance(const Shape& shape, const Vector3& own);

/// In world position, with edges of about `spacing` where the shape is a box, a cylinder or a torus (at most
/// about 20,000 triangles). A plane has none.
Mesh surface_of(const PlacedShape& placed, double spacing);

/// Closed surfaces about the origin, corners on the true surface, counter-clockwise from outside.
Mesh triangulate_box(const Vector3& size, const std::array<std::uint32_t, 3>& cells);
Mesh triangulate_sphere(double radius, std::uint32_t cells); ///< 12 cells^2 triangles
Mesh triangulate_cylinder(double radius, double height, std::uint32_t around, std::uint32_t rows,
                          std::uint32_t rings);
Mesh triangulate_torus(double radius, double tube, std::uint32_t around, std::uint32_t around_tube);
/// Open surfaces about the origin in the plane z = 0, counter-clockwise from above.
Mesh triangulate_rectangle(double width, double height, double edge);
Mesh triangulate_disc(double radius, std::uint32_t around, std::uint32_t rings);

} // namespace pliant
