// The renderer: what is drawn in which order.
//
//   bounds.comp, normals.comp      box and field range of the bodies; smooth normals of their meshes
//   *_shadow, surface              shadow map, seen from the sun
//   surface, particles, plane      colour, normal and depth of every sample, seen from the eye
//   visible, smooth (twice)        how much of the sun and of the sky each pixel sees
//   resolve                        light, tone, anti-aliasing; added up where samples need several drawings
#include "engine/render/renderer.h"

#include "backends/gl/gl_device.h"
#include "backends/gl/program.h"
#include "backends/gl/render/frame.h"
#include "backends/gl/render/geometry.h"
#include "backends/gl/render/host_drawing.h"
#include "backends/gl/render/legend.h"
#include "backends/gl/render/palette.h"
#include "backends/gl/render/targets.h"
#include "backends/gl/shader_text.h"
#include "engine/core/error.h"
#include "engine/scene/sample.h"

#include <Eigen/Geometry>
#include <glad/gl.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace pliant::gl {

namespace {

constexpr double particle_radius = 0.55; // in spacings: neighbours of a lattice overlap slightly

Source shader(const std::string& file) {
  Source source;
  source.text = "#version 430 core\n";
  append_file(source, "render/" + file, shader_texts());
  return source;
}

struct Programs {
  explicit Programs(Context& context)
      : bounds(context, "bounds", {{GL_COMPUTE_SHADER, shader("bounds.comp")}}),
        normals(context, "normals", {{GL_COMPUTE_SHADER, shader("normals.comp")}}),
        surface(context, "surface", stages("surface.vert", "surface.frag")),
        surface_shadow(context, "surface shadow", stages("surface.vert", "nothing.frag")),
        particles(context, "particles", stages("particles.vert", "particles.frag")),
        particles_shadow(context, "particles shadow",
                         stages("particles_shadow.vert", "particles_shadow.frag")),
        plane(context, "plane", stages("plane.vert", "plane.frag")),
        visible(context, "visible", stages("picture.vert", "visible.frag")),
        smooth(context, "smooth", stages("picture.vert", "smooth.frag")),
        resolve(context, "resolve", stages("picture.vert", "resolve.frag")) {}
  static Program::Stages stages(const char* vertex, const char* fragment) {
    return {{GL_VERTEX_SHADER, shader(vertex)}, {GL_FRAGMENT_SHADER, shader(fragment)}};
  }
  Program bounds, normals, surface, surface_shadow, particles, particles_shadow, plane, visible, smooth,
      resolve;
};

struct BodySurface {
  DrawnSurface surface;
  std::uint32_t first_vertex;
};
struct Obstacle {
  DrawnSurface surface;
  Motion motion;
  bool inside; // its far walls are drawn, seen from inside
  Box box;     // at rest
};
struct Plane {
  Vector3 normal;
  double offset;
  Motion motion;
};
struct Run { // of particles
  std::uint32_t first, count;
};

Box box_of(const Mesh& mesh) {
  Box box;
  for (const Vector3& vertex : mesh.vertices) box.add(vertex);
  return box;
}

Box moved(const Box& box, const Eigen::Matrix4d& matrix) {
  Box result;
  for (int i = 0; i < 8; ++i) result.add(Vector3((matrix * box.corner(i).homogeneous()).head<3>()));
  return result;
}

/// Everything that lives in the context.
struct Assets {
  explicit Assets(Context& context, const Scene& scene)
      : programs(context), targets(context, scene.render.size[0], scene.render.size[1], scene.render.samples),
        frame(context.gl()), planes(context.gl()), bounds(context.gl()), particle_copy(context.gl()),
        vertex_copy(context.gl()), particle_colours(context.gl()), particle_texture(context.gl()),
        colour_texture(context.gl()), field_texture(context.gl()), no_array(context.gl()), raw(context.gl()),
        compared(context.gl()) {}
  Programs programs;
  Targets targets;
  GlArray frame, planes, bounds, particle_copy, vertex_copy, particle_colours;
  Texture particle_texture, colour_texture, field_texture;
  VertexArray no_array;
  Sampler raw, compared;
  std::vector<BodySurface> bodies;
  std::vector<Obstacle> obstacles;
};

class GlRenderer final : public Renderer {
public:
  GlRenderer(Device& simulation, const Scene& scene, const Model& model, std::string label)
      : scene_(scene.render), label_(std::move(label)), radius_(particle_radius * model.spacing),
        particle_count_(model.count()) {
    if (is_gl(simulation)) {
      context_ = &context_of(simulation);
    } else {
      own_ = Context::open(0);
      context_ = own_.get();
    }
    const Scope scope(*context_);
    assets_ = std::make_unique<Assets>(*context_, scene);
    upload_bodies(scene, model);
    upload_boundaries(scene);
    upload_tables();
    std::vector<Box> boxes;
    for (const Obstacle& one : assets_->obstacles)
      if (!one.inside) boxes.push_back(one.box);
    stage_ = arrange(scene, outline_at_start(model), boxes);
    if (stage_.ground) planes_.push_back({stage_.ground->head<3>(), (*stage_.ground)[3], Motion{}});
    if (planes_.size() > max_planes)
      throw Error(ExitCode::usage, "the scene has " + std::to_string(planes_.size()) +
                                       " visible planes, and " + std::to_string(max_planes) +
                                       " can be drawn; set visible = false on some");
    fill_view(block_, stage_, scene_.size[0], scene_.size[1], Eigen::Vector2d::Zero());
  }

  ~GlRenderer() override {
    try {
      const Scope scope(*context_);
      assets_.reset();
    } catch (const Error&) {
      // The context is in use by another thread: the driver frees it all with it, and names are not reused
      // before.
      static_cast<void>(assets_.release());
    }
  }

  Image draw(Device& simulation, const RenderState& state) override {
    const Scope scope(*context_);
    gl().MemoryBarrier(GL_ALL_BARRIER_BITS);
    const GLuint particles = state.particle ? source(simulation, *state.particle, assets_->particle_copy) : 0;
    const GLuint vertices = state.vertex ? source(simulation, *state.vertex, assets_->vertex_copy) : 0;
    const bool meshes = vertices && !assets_->bodies.empty();
    const std::vector<Run>& runs = meshes ? bare_ : all_;
    if (particles) bind_particles(particles, *state.particle);
    if (meshes) check_vertices(*state.vertex);

    Box casters = measure(particles, meshes ? vertices : 0, runs);
    std::vector<Eigen::Matrix4d> motions;
    for (const Obstacle& one : assets_->obstacles) {
      motions.push_back(motion_matrix(one.motion, state.time));
      const Box box = moved(one.box, motions.back());
      if (!one.inside) casters.add(box);
    }
    fill_shadow(block_, stage_, casters, Targets::map);
    block_.sizes[0] = static_cast<float>(radius_);
    block_.sizes[3] = static_cast<float>(assets_->targets.samples);
    if (meshes) {
      for (const BodySurface& body : assets_->bodies)
        body.surface.update(assets_->programs.normals.name(), vertices, body.first_vertex);
      gl().MemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
    }

    const Targets& targets = assets_->targets;
    for (unsigned pass = 0; pass < targets.passes; ++pass) {
      // Places of a low-discrepancy sequence (Roberts 2018) around the pixel's middle.
      const Eigen::Vector2d jitter =
          targets.passes == 1
              ? Eigen::Vector2d(0, 0)
              : Eigen::Vector2d(Eigen::Vector2d(std::fmod(0.5 + 0.7548776662 * pass, 1.0) - 0.5,
                                                std::fmod(0.5 + 0.5698402910 * pass, 1.0) - 0.5) /
                                std::sqrt(double(targets.samples)));
      fill_view(block_, stage_, targets.width, targets.height, jitter);
      block_.axis[3] = targets.first_sample[0];
      block_.ray_up[3] = targets.first_sample[1];
      upload_frame(state.time);
      if (pass == 0) draw_shadow(meshes, particles ? runs : none_, motions);
      draw_samples(meshes, particles ? runs : none_, motions, state.time);
      draw_light(pass);
    }
    Image image = read_picture();
    if (field_shown()) draw_legend(image, label_, low_, high_, !scene_.range);
    return image;
  }

private:
  struct Scope {
    explicit Scope(Context& context)
        : current(context, Current::Restore::foreign), host(context), drawing(context) {}
    Current current;
    HostState host;
    HostDrawing drawing;
  };

  const GladGLContext& gl() const { return context_->gl(); }
  bool field_shown() const { return scene_.color != "body"; }

  void upload_bodies(const Scene& scene, const Model& model);
  void upload_boundaries(const Scene& scene);
  void upload_tables();
  GLuint source(Device& simulation, const BufferStorage& buffer, const GlArray& copy);
  void bind_particles(GLuint particles, const BufferStorage& buffer);
  void check_vertices(const BufferStorage& buffer) const;
  Box measure(GLuint particles, GLuint vertices, const std::vector<Run>& runs);
  void upload_frame(double time);
  void draw_surfaces(GLuint program, bool shadow, bool meshes,
                     const std::vector<Eigen::Matrix4d>& motions) const;
  void draw_particles(GLuint program, const std::vector<Run>& runs) const;
  void draw_shadow(bool meshes, const std::vector<Run>& runs,
                   const std::vector<Eigen::Matrix4d>& motions) const;
  void draw_samples(bool meshes, const std::vector<Run>& runs, const std::vector<Eigen::Matrix4d>& motions,
                    double time) const;
  void draw_light(unsigned pass) const;
  Image read_picture() const;
  std::vector<Eigen::Vector4d> planes_at(double time) const;

  RenderSettings scene_;
  std::string label_;
  double radius_;
  std::size_t particle_count_;
  std::unique_ptr<Context> own_;
  Context* context_ = nullptr;
  std::unique_ptr<Assets> assets_;
  Stage stage_;
  FrameBlock block_;
  std::vector<Plane> planes_;
  std::vector<Run> all_, bare_, none_; // particles of all bodies, of those whose mesh is not drawn
  std::uint32_t vertices_needed_ = 0;
  double low_ = 1e300, high_ = -1e300; // of the field
};

void GlRenderer::upload_bodies(const Scene& scene, const Model& model) {
  const std::vector<Vector3> colours = body_colours(scene, model);
  const std::filesystem::path folder = scene.file.parent_path();
  std::vector<std::array<std::uint8_t, 4>> particle_colours(std::max<std::size_t>(model.count(), 1));
  std::uint32_t first_vertex = 0;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const BodyModel& body = model.bodies[b];
    const bool by_region =
        b < scene.bodies.size() && !scene.bodies[b].color && !scene.bodies[b].regions.empty();
    all_.push_back({body.first, body.count});
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      Vector3 colour = colours[b];
      if (by_region && scene.materials[model.material[i]].name != scene.bodies[b].material)
        colour = to_linear(scene.materials[model.material[i]].color);
      for (int c = 0; c < 3; ++c)
        particle_colours[i][c] =
            static_cast<std::uint8_t>(std::lround(255 * std::sqrt(std::clamp(colour[c], 0.0, 1.0))));
    }
    if (!body.surface || scene.render.show != "surface") {
      bare_.push_back({body.first, body.count});
      if (body.surface) first_vertex += static_cast<std::uint32_t>(body.surface->vertices.size());
      continue;
    }
    std::vector<Vector3> vertex_colours(body.surface->vertices.size(), colours[b]);
    if (by_region)
      for (const MaterialRegion& region : scene.bodies[b].regions) { // later ones win
        const Material* material = scene.material(region.material);
        const ShapeQuery query(region.region, folder);
        for (std::size_t v = 0; material && v < vertex_colours.size(); ++v)
          if (query.contains(body.surface->vertices[v])) vertex_colours[v] = to_linear(material->color);
      }
    assets_->bodies.push_back({DrawnSurface(*context_, *body.surface, vertex_colours), first_vertex});
    first_vertex += static_cast<std::uint32_t>(body.surface->vertices.size());
  }
  vertices_needed_ = first_vertex;
  fill(gl(), assets_->particle_colours, 4 * particle_colours.size(), particle_colours.data(), GL_STATIC_DRAW);
}

void GlRenderer::upload_boundaries(const Scene& scene) {
  const Vector3 grey = to_linear(Vector3(0.62, 0.64, 0.67));
  for (const Boundary& boundary : scene.boundaries) {
    if (!boundary.visible) continue;
    if (boundary.shape.kind == Shape::Kind::plane) {
      planes_.push_back({boundary.shape.normal.normalized(), boundary.shape.offset, boundary.motion});
      continue;
    }
    const ShapeQuery query(boundary.shape, scene.file.parent_path());
    const Mesh& mesh = query.surface();
    DrawnSurface surface(*context_, mesh, std::vector<Vector3>(mesh.vertices.size(), grey));
    std::vector<std::array<float, 4>> vertices;
    for (const Vector3& v : mesh.vertices)
      vertices.push_back(
          {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), NAN});
    const GlArray uploaded(gl());
    fill(gl(), uploaded, 16 * vertices.size(), vertices.data(), GL_STATIC_DRAW);
    surface.update(assets_->programs.normals.name(), uploaded.name(), 0);
    gl().MemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
    assets_->obstacles.push_back({std::move(surface), boundary.motion, boundary.inside, box_of(mesh)});
  }
}

void GlRenderer::upload_tables() {
  std::vector<std::array<float, 4>> colours;
  for (const Colour& c : field_colours())
    colours.push_back({static_cast<float>(to_linear(c[0] / 255.0)),
                       static_cast<float>(to_linear(c[1] / 255.0)),
                       static_cast<float>(to_linear(c[2] / 255.0)), 1});
  gl().ActiveTexture(GL_TEXTURE0);
  gl().BindTexture(GL_TEXTURE_1D, assets_->field_texture.name());
  gl().TexStorage1D(GL_TEXTURE_1D, 1, GL_RGBA16F, 256);
  gl().TexSubImage1D(GL_TEXTURE_1D, 0, 0, 256, GL_RGBA, GL_FLOAT, colours.data());
  gl().TexParameteri(GL_TEXTURE_1D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl().TexParameteri(GL_TEXTURE_1D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl().BindTexture(GL_TEXTURE_1D, 0);
  gl().BindTexture(GL_TEXTURE_BUFFER, assets_->colour_texture.name());
  gl().TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA8, assets_->particle_colours.name());
  gl().BindTexture(GL_TEXTURE_BUFFER, 0);

  // Beyond the map nothing stands between a point and the sun.
  const float lit[4] = {1, 1, 1, 1};
  for (const Sampler* sampler : {&assets_->raw, &assets_->compared}) {
    const bool compared = sampler == &assets_->compared;
    gl().SamplerParameteri(sampler->name(), GL_TEXTURE_MIN_FILTER, compared ? GL_LINEAR : GL_NEAREST);
    gl().SamplerParameteri(sampler->name(), GL_TEXTURE_MAG_FILTER, compared ? GL_LINEAR : GL_NEAREST);
    gl().SamplerParameteri(sampler->name(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    gl().SamplerParameteri(sampler->name(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    gl().SamplerParameterfv(sampler->name(), GL_TEXTURE_BORDER_COLOR, lit);
  }
  gl().SamplerParameteri(assets_->compared.name(), GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl().SamplerParameteri(assets_->compared.name(), GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  fill(gl(), assets_->frame, sizeof(FrameBlock), nullptr, GL_DYNAMIC_DRAW);
  fill(gl(), assets_->planes, 16 * max_planes, nullptr, GL_DYNAMIC_DRAW);
  fill(gl(), assets_->bounds, 32, nullptr, GL_DYNAMIC_COPY);
}

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

} // namespace

} // namespace pliant::gl

namespace pliant {

std::unique_ptr<Renderer> make_renderer(Device& simulation, const Scene& scene, const Model& model,
                                        const std::string& field_label) {
  return std::make_unique<gl::GlRenderer>(simulation, scene, model, field_label);
}

} // namespace pliant
