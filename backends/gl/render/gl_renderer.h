// The renderer's parts: programs, what lives in the context, and the class that draws. See renderer.cpp.
#pragma once

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
#include "engine/solver/motion.h"

#include <Eigen/Geometry>
#include <glad/gl.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace pliant::gl {

inline constexpr double particle_radius = 0.55; // in spacings: neighbours of a lattice overlap slightly

/// A file below shaders/render with what it includes.
Source shader(const std::string& file);
Box box_of(const Mesh& mesh);
/// The box of a box's corners, moved.
Box moved(const Box& box, const Eigen::Matrix4d& matrix);

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
  std::uint32_t first_vertex, first_triangle;
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
    const std::vector<std::uint32_t> torn =
        state.torn ? simulation.download_uint(state.torn) : std::vector<std::uint32_t>{};
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
      if (released(one.motion, state.time)) { // gone: drawn nowhere
        motions.emplace_back(Eigen::Matrix4d::Zero());
        continue;
      }
      motions.push_back(motion_matrix(one.motion, state.time));
      const Box box = moved(one.box, motions.back());
      if (!one.inside) casters.add(box);
    }
    fill_shadow(block_, stage_, casters, Targets::map);
    block_.sizes[0] = static_cast<float>(radius_);
    block_.sizes[3] = static_cast<float>(assets_->targets.samples);
    if (meshes) {
      if (state.torn)
        for (BodySurface& body : assets_->bodies)
          body.surface.tear(std::span(torn).subspan(body.first_triangle, body.surface.triangle_count()));
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

} // namespace pliant::gl
