// Meshes on the GPU: topology uploaded once, normals gathered from the current vertices each picture.
#pragma once

#include "backends/gl/context.h"
#include "backends/gl/render/objects.h"
#include "engine/scene/mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace pliant::gl {

class DrawnSurface {
public:
  /// `colours`: linear, one a vertex of the mesh.
  DrawnSurface(const Context& context, const Mesh& mesh, const std::vector<Vector3>& colours);

  /// Gathers positions and normals out of `vertices` (vec4 each, from element `first` on) with the program of
  /// normals.comp. The caller issues the barrier.
  void update(GLuint program, GLuint vertices, std::uint32_t first) const;
  void draw() const;
  std::uint32_t vertex_count() const { return vertex_count_; }

private:
  const Context& context_;
  std::uint32_t vertex_count_, corner_count_ = 0, index_count_ = 0;
  GlArray corners_, fans_, triangles_, drawn_, colours_, indices_;
  VertexArray array_;
};

} // namespace pliant::gl
