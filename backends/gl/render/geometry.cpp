// Uploads meshes split at their creases.
#include "backends/gl/render/geometry.h"

#include "backends/gl/render/creases.h"

#include <algorithm>

namespace pliant::gl {

DrawnSurface::DrawnSurface(const Context& context, const Mesh& mesh, const std::vector<Vector3>& colours,
                           bool tears)
    : context_(context), vertex_count_(static_cast<std::uint32_t>(mesh.vertices.size())),
      triangle_count_(static_cast<std::uint32_t>(mesh.triangles.size())), corners_(context.gl()),
      fans_(context.gl()), triangles_(context.gl()), drawn_(context.gl()), colours_(context.gl()),
      indices_(context.gl()), array_(context.gl()) {
  const GladGLContext& gl = context.gl();
  const DrawnMesh split = split_creases(mesh);
  if (tears) whole_ = split.triangles, corners_of_ = split.indices;
  corner_count_ = static_cast<std::uint32_t>(split.corners.size());
  index_count_ = static_cast<std::uint32_t>(3 * split.indices.size());
  std::vector<std::array<float, 3>> corner_colours;
  for (const auto& corner : split.corners) {
    const Vector3& c = colours[corner[0]];
    corner_colours.push_back(
        {static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z())});
  }
  fill(gl, corners_, 16 * split.corners.size(), split.corners.data(), GL_STATIC_DRAW);
  fill(gl, fans_, 4 * split.fans.size(), split.fans.data(), GL_STATIC_DRAW);
  fill(gl, triangles_, 12 * split.triangles.size(), split.triangles.data(), GL_STATIC_DRAW);
  fill(gl, drawn_, 32 * split.corners.size(), nullptr, GL_DYNAMIC_COPY);
  fill(gl, colours_, 12 * corner_colours.size(), corner_colours.data(), GL_STATIC_DRAW);
  fill(gl, indices_, 12 * split.indices.size(), split.indices.data(), GL_STATIC_DRAW);

  gl.BindVertexArray(array_.name());
  gl.BindBuffer(GL_ARRAY_BUFFER, drawn_.name());
  gl.VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, 32, nullptr);
  gl.VertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, 32, reinterpret_cast<const void*>(16));
  gl.BindBuffer(GL_ARRAY_BUFFER, colours_.name());
  gl.VertexAttribPointer(2, 3, GL_FLOAT, GL_FALSE, 12, nullptr);
  for (GLuint i = 0; i < 3; ++i) gl.EnableVertexAttribArray(i);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
  gl.BindVertexArray(0);
  gl.BindBuffer(GL_ARRAY_BUFFER, 0);
}

void DrawnSurface::update(GLuint program, GLuint vertices, std::uint32_t first) const {
  if (corner_count_ == 0) return;
  const GladGLContext& gl = context_.gl();
  gl.UseProgram(program);
  const GLuint buffers[] = {vertices, corners_.name(), fans_.name(), triangles_.name(), drawn_.name()};
  for (GLuint i = 0; i < 5; ++i) gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]);
  gl.Uniform1ui(gl.GetUniformLocation(program, "count"), corner_count_);
  gl.Uniform1ui(gl.GetUniformLocation(program, "first_vertex"), first);
  const std::uint32_t groups = (corner_count_ + 127) / 128, rows = (groups + 65534) / 65535;
  gl.DispatchCompute(std::min(groups, 65535u), rows, 1);
}

void DrawnSurface::tear(std::span<const std::uint32_t> torn) {
  if (std::equal(torn.begin(), torn.end(), torn_.begin(), torn_.end())) return;
  torn_.assign(torn.begin(), torn.end());
  std::vector<std::array<std::uint32_t, 3>> triangles(whole_), left;
  for (std::size_t t = 0; t < whole_.size(); ++t) {
    if (torn_[t] == 0)
      left.push_back(corners_of_[t]);
    else // no area, no normal
      triangles[t] = {whole_[t][0], whole_[t][0], whole_[t][0]};
  }
  index_count_ = static_cast<std::uint32_t>(3 * left.size());
  const GladGLContext& gl = context_.gl();
  fill(gl, triangles_, 12 * triangles.size(), triangles.data(), GL_DYNAMIC_DRAW);
  gl.BindVertexArray(array_.name());
  fill(gl, indices_, 12 * left.size(), left.data(), GL_DYNAMIC_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
  gl.BindVertexArray(0);
}

void DrawnSurface::draw() const {
  const GladGLContext& gl = context_.gl();
  gl.BindVertexArray(array_.name());
  gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(index_count_), GL_UNSIGNED_INT, nullptr);
}

} // namespace pliant::gl
