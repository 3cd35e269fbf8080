// The renderer: what is drawn in which order.
//
//   bounds.comp, normals.comp      box and field range of the bodies; smooth normals of their meshes
//   *_shadow, surface              shadow map, seen from the sun
//   surface, particles, plane      colour, normal and depth of every sample, seen from the eye
//   visible, smooth (twice)        how much of the sun and of the sky each pixel sees
//   resolve                        light, tone, anti-aliasing; added up where samples need several drawings
#include "backends/gl/render/gl_renderer.h"

namespace pliant::gl {

// The simulation's own buffer where it is in this context, else a copy of its values.
GLuint GlRenderer::source(Device& simulation, const BufferStorage& buffer, const GlArray& copy) {
  if (!own_ && simulation.info().backend == "gl") return gl_name(buffer);
  std::vector<float> values;
  for (const Real4<double>& v : simulation.download_real4(&buffer))
    for (const double c : {v.x, v.y, v.z, v.w}) values.push_back(static_cast<float>(c));
  context_->make_current(); // the download may have left it
  fill(gl(), copy, 4 * values.size(), values.data(), GL_STREAM_DRAW);
  return copy.name();
}

void GlRenderer::bind_particles(GLuint particles, const BufferStorage& buffer) {
  GLint most = 0;
  gl().GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (particle_count_ > static_cast<std::size_t>(most))
    throw Error(ExitCode::too_large, std::to_string(particle_count_) + " particles are more than the " +
                                         std::to_string(most) + " of GL_MAX_TEXTURE_BUFFER_SIZE on " +
                                         context_->renderer() + "; draw surfaces, or use a larger spacing");
  if (buffer.count() < particle_count_)
    throw Error(ExitCode::internal, "buffer '" + buffer.name() + "' holds " + std::to_string(buffer.count()) +
                                        " particles, and the model has " + std::to_string(particle_count_));
  gl().ActiveTexture(GL_TEXTURE2);
  gl().BindTexture(GL_TEXTURE_BUFFER, assets_->particle_texture.name());
  gl().TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, particles);
}

void GlRenderer::check_vertices(const BufferStorage& buffer) const {
  if (buffer.count() < vertices_needed_)
    throw Error(ExitCode::internal, "buffer '" + buffer.name() + "' holds " + std::to_string(buffer.count()) +
                                        " vertices, and the carried meshes have " +
                                        std::to_string(vertices_needed_));
}

// The box of all bodies; widens the field's range by what is drawn.
Box GlRenderer::measure(GLuint particles, GLuint vertices, const std::vector<Run>& runs) {
  const std::array<std::uint32_t, 8> start{~0u, ~0u, ~0u, ~0u, 0, 0, 0, 0};
  fill(gl(), assets_->bounds, sizeof start, start.data(), GL_DYNAMIC_COPY);
  const GLuint program = assets_->programs.bounds.name();
  gl().UseProgram(program);
  gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, assets_->bounds.name());
  const auto gather = [&](GLuint points, std::uint32_t first, std::uint32_t count) {
    if (!points || count == 0) return;
    gl().BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, points);
    gl().Uniform1ui(gl().GetUniformLocation(program, "first_point"), first);
    gl().Uniform1ui(gl().GetUniformLocation(program, "count"), count);
    gl().DispatchCompute(std::min((count + 127) / 128, 256u), 1, 1);
  };
  for (const Run& run : runs) gather(particles, run.first, run.count);
  if (vertices)
    for (const BodySurface& body : assets_->bodies)
      gather(vertices, body.first_vertex, body.surface.vertex_count());
  gl().MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::array<std::uint32_t, 8> found{};
  gl().BindBuffer(GL_COPY_READ_BUFFER, assets_->bounds.name());
  gl().GetBufferSubData(GL_COPY_READ_BUFFER, 0, sizeof found, found.data());
  const auto value = [&](int i) {
    const std::uint32_t bits = found[i];
    return double(std::bit_cast<float>((bits & 0x80000000u) ? bits & 0x7fffffffu : ~bits));
  };
  if (scene_.range) {
    low_ = (*scene_.range)[0];
    high_ = (*scene_.range)[1];
  } else if (found[3] <= found[7]) {
    low_ = std::min(low_, value(3));
    high_ = std::max(high_, value(7));
  }
  Box box;
  if (found[0] > found[4] || found[1] > found[5] || found[2] > found[6]) return box;
  const double margin = radius_;
  box.low = Vector3(value(0), value(1), value(2)) - Vector3::Constant(margin);
  box.high = Vector3(value(4), value(5), value(6)) + Vector3::Constant(margin);
  return box;
}

std::vector<Eigen::Vector4d> GlRenderer::planes_at(double time) const {
  std::vector<Eigen::Vector4d> planes;
  for (const Plane& plane : planes_) {
    if (released(plane.motion, time)) { // gone: keeps its index, and every eye is behind it
      planes.emplace_back(0, 1, 0, 1e30);
      continue;
    }
    const Eigen::Matrix4d motion = motion_matrix(plane.motion, time);
    const Vector3 normal = motion.topLeftCorner<3, 3>() * plane.normal;
    const Vector3 point = (motion * Vector3(plane.offset * plane.normal).homogeneous()).head<3>();
    planes.emplace_back(normal.x(), normal.y(), normal.z(), normal.dot(point));
  }
  return planes;
}

void GlRenderer::upload_frame(double time) {
  const double width = high_ - low_;
  block_.field = {static_cast<float>(low_), width > 0 ? static_cast<float>(1 / width) : 0.0f,
                  field_shown() && low_ <= high_ ? 1.0f : 0.0f, 0.0f};
  fill(gl(), assets_->frame, sizeof block_, &block_, GL_DYNAMIC_DRAW);
  std::array<std::array<float, 4>, max_planes> packed{};
  const std::vector<Eigen::Vector4d> planes = planes_at(time);
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (int c = 0; c < 4; ++c) packed[i][c] = static_cast<float>(planes[i][c]);
  fill(gl(), assets_->planes, sizeof packed, packed.data(), GL_DYNAMIC_DRAW);
  gl().BindBufferBase(GL_UNIFORM_BUFFER, 0, assets_->frame.name());
  gl().BindBufferBase(GL_UNIFORM_BUFFER, 1, assets_->planes.name());
}

void GlRenderer::draw_surfaces(GLuint program, bool shadow, bool meshes,
                               const std::vector<Eigen::Matrix4d>& motions) const {
  gl().UseProgram(program);
  gl().Uniform1i(gl().GetUniformLocation(program, "shadow"), shadow);
  const GLint move = gl().GetUniformLocation(program, "move");
  const auto set_move = [&](const Eigen::Matrix4f& matrix) {
    gl().UniformMatrix4fv(move, 1, GL_FALSE, matrix.data());
  };
  const GLint field = gl().GetUniformLocation(program, "has_field");
  gl().Uniform1i(field, 1);
  set_move(Eigen::Matrix4f::Identity());
  if (meshes)
    for (const BodySurface& body : assets_->bodies) body.surface.draw();
  gl().Uniform1i(field, 0);
  for (std::size_t i = 0; i < assets_->obstacles.size(); ++i) {
    const Obstacle& one = assets_->obstacles[i];
    if (motions[i].isZero(0)) continue; // gone
    if (shadow && one.inside) continue; // it would shut the sun out
    set_move(motions[i].cast<float>());
    if (one.inside) { // only walls that are seen from inside
      gl().Enable(GL_CULL_FACE);
      gl().CullFace(GL_BACK);
      gl().FrontFace(GL_CW);
    }
    one.surface.draw();
    gl().Disable(GL_CULL_FACE);
    gl().FrontFace(GL_CCW);
  }
}

void GlRenderer::draw_particles(GLuint program, const std::vector<Run>& runs) const {
  if (runs.empty()) return;
  gl().UseProgram(program);
  gl().BindVertexArray(assets_->no_array.name());
  gl().ActiveTexture(GL_TEXTURE3);
  gl().BindTexture(GL_TEXTURE_BUFFER, assets_->colour_texture.name());
  for (const Run& run : runs)
    gl().DrawArrays(GL_TRIANGLES, static_cast<GLint>(6 * run.first), static_cast<GLsizei>(6 * run.count));
}

void GlRenderer::draw_shadow(bool meshes, const std::vector<Run>& runs,
                             const std::vector<Eigen::Matrix4d>& motions) const {
  gl().BindFramebuffer(GL_FRAMEBUFFER, assets_->targets.sun.name());
  gl().Viewport(0, 0, Targets::map, Targets::map);
  gl().ClearDepth(1);
  gl().Clear(GL_DEPTH_BUFFER_BIT);
  gl().Enable(GL_DEPTH_TEST);
  draw_surfaces(assets_->programs.surface_shadow.name(), true, meshes, motions);
  draw_particles(assets_->programs.particles_shadow.name(), runs);
  gl().Disable(GL_DEPTH_TEST);
}

void GlRenderer::draw_samples(bool meshes, const std::vector<Run>& runs,
                              const std::vector<Eigen::Matrix4d>& motions, double time) const {
  const Targets& targets = assets_->targets;
  gl().BindFramebuffer(GL_FRAMEBUFFER, targets.seen.name());
  gl().Viewport(0, 0, static_cast<GLsizei>(targets.width), static_cast<GLsizei>(targets.height));
  gl().ClearColor(0, 0, 0, 0);
  gl().Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  gl().Enable(GL_DEPTH_TEST);
  gl().ActiveTexture(GL_TEXTURE1);
  gl().BindTexture(GL_TEXTURE_1D, assets_->field_texture.name());
  draw_surfaces(assets_->programs.surface.name(), false, meshes, motions);
  draw_particles(assets_->programs.particles.name(), runs);

  const GLuint program = assets_->programs.plane.name();
  gl().UseProgram(program);
  gl().BindVertexArray(assets_->no_array.name());
  const std::vector<Eigen::Vector4d> planes = planes_at(time);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Vector3 normal = planes[i].head<3>();
    const double height = normal.dot(stage_.view.eye) - planes[i][3];
    if (height <= 0) continue; // seen from within the ground: not at all
    const auto vector = [&](const char* name, const Vector3& v) {
      gl().Uniform3f(gl().GetUniformLocation(program, name), static_cast<float>(v.x()),
                     static_cast<float>(v.y()), static_cast<float>(v.z()));
    };
    const Vector3 first = normal.unitOrthogonal();
    vector("foot", stage_.view.eye - height * normal);
    vector("first", first);
    vector("second", normal.cross(first));
    gl().Uniform4f(gl().GetUniformLocation(program, "plane_normal"), static_cast<float>(normal.x()),
                   static_cast<float>(normal.y()), static_cast<float>(normal.z()), static_cast<float>(i));
    gl().DrawArrays(GL_TRIANGLES, 0, 12);
  }
  gl().Disable(GL_DEPTH_TEST);
}

void GlRenderer::draw_light(unsigned pass) const {
  const Targets& targets = assets_->targets;
  const auto bind = [&](int unit, GLenum target, const Texture& texture, GLuint sampler) {
    gl().ActiveTexture(GL_TEXTURE0 + unit);
    gl().BindTexture(target, texture.name());
    gl().BindSampler(unit, sampler);
  };
  bind(4, GL_TEXTURE_2D_MULTISAMPLE, targets.colour, 0);
  bind(5, GL_TEXTURE_2D_MULTISAMPLE, targets.normal, 0);
  bind(6, GL_TEXTURE_2D_MULTISAMPLE, targets.depth, 0);
  bind(7, GL_TEXTURE_2D, targets.shadow, assets_->raw.name());
  bind(8, GL_TEXTURE_2D, targets.shadow, assets_->compared.name());
  gl().BindVertexArray(assets_->no_array.name());
  const auto paint = [&](const Framebuffer& framebuffer) {
    gl().BindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    gl().DrawArrays(GL_TRIANGLES, 0, 3);
  };
  gl().UseProgram(assets_->programs.visible.name());
  paint(targets.roughly);

  const GLuint smooth = assets_->programs.smooth.name();
  gl().UseProgram(smooth);
  const GLint direction = gl().GetUniformLocation(smooth, "direction");
  gl().Uniform2i(direction, 1, 0);
  bind(9, GL_TEXTURE_2D, targets.rough, assets_->raw.name());
  paint(targets.halfway);
  gl().Uniform2i(direction, 0, 1);
  bind(9, GL_TEXTURE_2D, targets.between, assets_->raw.name());
  paint(targets.roughly);

  const GLuint resolve = assets_->programs.resolve.name();
  gl().UseProgram(resolve);
  gl().Uniform1f(gl().GetUniformLocation(resolve, "share"), 1.0f / static_cast<float>(targets.passes));
  bind(9, GL_TEXTURE_2D, targets.rough, assets_->raw.name());
  if (pass > 0) {
    gl().Enable(GL_BLEND);
    gl().BlendFunc(GL_ONE, GL_ONE);
  }
  paint(targets.summed);
  gl().Disable(GL_BLEND);
  for (int unit = 4; unit < 10; ++unit) gl().BindSampler(unit, 0);
}

Image GlRenderer::read_picture() const {
  const Targets& targets = assets_->targets;
  Image image(targets.width, targets.height, Colour{});
  std::vector<std::uint8_t> rows(4 * std::size_t(targets.width) * targets.height);
  gl().BindFramebuffer(GL_READ_FRAMEBUFFER, targets.summed.name());
  gl().ReadPixels(0, 0, static_cast<GLsizei>(targets.width), static_cast<GLsizei>(targets.height), GL_RGBA,
                  GL_UNSIGNED_BYTE, rows.data());
  if (const GLenum error = gl().GetError(); error != GL_NO_ERROR)
    throw Error(ExitCode::internal,
                "drawing failed on " + context_->renderer() + " with GL error " + std::to_string(error));
  for (unsigned y = 0; y < targets.height; ++y) {
    const std::uint8_t* row = &rows[4 * std::size_t(targets.height - 1 - y) * targets.width];
    for (unsigned x = 0; x < targets.width; ++x) std::memcpy(image.at(x, y), row + 4 * x, 3);
  }
  return image;
}

} // namespace pliant::gl

namespace pliant {

std::unique_ptr<Renderer> make_renderer(Device& simulation, const Scene& scene, const Model& model,
                                        const std::string& field_label) {
  return std::make_unique<gl::GlRenderer>(simulation, scene, model, field_label);
}

} // namespace pliant
