// Meshes on the GPU: topology uploaded once, normals gathered from the current vertices each picture.
#pragma once

#include "backends/gl/context.h"
#include "backends/gl/render/objects.h"
#include "engine/scene/mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant::gl {

class DrawnSurface {
public:
  /// `colours`: linear, one a vertex of the mesh. `tears`: keeps what tear() needs.
  DrawnSurface(const Context& context, const Mesh& mesh, const std::vector<Vector3>& colours,
               bool tears = false);

  /// Gathers positions and normals out of `vertices` (vec4 each, from element `first` on) with the program of
  /// normals.comp. The caller issues the barrier.
  void update(GLuint program, GLuint vertices, std::uint32_t first) const;
  void draw() const;
  /// Leaves out the triangles that are marked, from the picture and from the normals of those that stay; one
  /// mark a triangle of the mesh. Only of surfaces that tear.
  void tear(std::span<const std::uint32_t> torn);
  std::uint32_t triangle_count() const { return triangle_count_; }
  std::uint32_t vertex_count() const { return vertex_count_; }

private:
  const Context& context_;
  std::uint32_t vertex_count_, triangle_count_, corner_count_ = 0, index_count_ = 0;
  std::vector<std::array<std::uint32_t, 3>> whole_, corners_of_; ///< triangles; of vertices, and of corners
  std::vector<std::uint32_t> torn_;
  GlArray corners_, fans_, triangles_, drawn_, colours_, indices_;
  VertexArray array_;
};

} // namespace pliant::gl
