// What the renderer uploads once: bodies, boundaries and tables.
#include "backends/gl/render/gl_renderer.h"

#include "engine/model/failure.h"

namespace pliant::gl {

Source shader(const std::string& file) {
  Source source;
  source.text = "#version 430 core\n";
  append_file(source, "render/" + file, shader_texts());
  return source;
}

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

void GlRenderer::upload_bodies(const Scene& scene, const Model& model) {
  const std::vector<Vector3> colours = body_colours(scene, model);
  const std::filesystem::path folder = scene.file.parent_path();
  std::vector<std::array<std::uint8_t, 4>> particle_colours(std::max<std::size_t>(model.count(), 1));
  std::uint32_t first_vertex = 0, first_triangle = 0;
  const bool tears = can_break(scene, model);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const BodyModel& body = model.bodies[b];
    const bool by_region =
        b < scene.bodies.size() && !scene.bodies[b].color && !scene.bodies[b].regions.empty();
    all_.push_back({body.first, body.count});
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      Vector3 colour = colours[b];
      if (by_region && typed_material(scene, model, i).name != scene.bodies[b].material)
        colour = to_linear(typed_material(scene, model, i).color);
      for (int c = 0; c < 3; ++c)
        particle_colours[i][c] =
            static_cast<std::uint8_t>(std::lround(255 * std::sqrt(std::clamp(colour[c], 0.0, 1.0))));
    }
    if (!body.surface || scene.render.show != "surface") {
      bare_.push_back({body.first, body.count});
      if (body.surface) {
        first_vertex += static_cast<std::uint32_t>(body.surface->vertices.size());
        first_triangle += static_cast<std::uint32_t>(body.surface->triangles.size());
      }
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
    assets_->bodies.push_back(
        {DrawnSurface(*context_, *body.surface, vertex_colours, tears), first_vertex, first_triangle});
    first_vertex += static_cast<std::uint32_t>(body.surface->vertices.size());
    first_triangle += static_cast<std::uint32_t>(body.surface->triangles.size());
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

} // namespace pliant::gl
