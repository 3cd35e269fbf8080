// Small scenes for the renderer's tests, made by hand: no simulation runs.
#pragma once

#include "backends/openmp/device.h"
#include "engine/core/error.h"
#include "engine/io/png.h"
#include "engine/render/renderer.h"
#include "engine/scene/sample.h"

#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace pliant::test {

/// A scene, its model, and the buffers that a simulation would hand to the renderer.
struct Show {
  Scene scene;
  Model model;
  std::unique_ptr<Device> device;
  Buffer particle, vertex;

  explicit Show(std::unique_ptr<Device> on = openmp::make_device(Precision::single_precision, 1))
      : device(std::move(on)) {
    scene.render.size = {320, 240};
    scene.render.samples = 4;
    model.spacing = 0.1;
    Material material;
    material.name = "clay";
    scene.materials.push_back(material);
  }

  void add_floor(double height = 0) {
    Boundary floor;
    floor.shape.kind = Shape::Kind::plane;
    floor.shape.normal = {0, 1, 0};
    floor.shape.offset = height;
    scene.boundaries.push_back(floor);
  }
  BodyModel& add_body(const std::vector<Vector3>& points, const Vector3& colour) {
    Body body;
    body.material = "clay";
    body.color = colour;
    scene.bodies.push_back(body);
    BodyModel added;
    added.first = static_cast<std::uint32_t>(model.position.size());
    added.count = static_cast<std::uint32_t>(points.size());
    added.color = colour;
    model.position.insert(model.position.end(), points.begin(), points.end());
    model.material.resize(model.position.size(), 0);
    model.body.resize(model.position.size(), static_cast<std::uint32_t>(model.bodies.size()));
    model.bodies.push_back(added);
    return model.bodies.back();
  }
  /// Fills the buffers: positions at rest, fields 0.
  void upload(const std::vector<double>& field = {}) {
    std::vector<Real4<double>> particles, vertices;
    for (std::size_t i = 0; i < model.position.size(); ++i) {
      const Vector3& p = model.position[i];
      particles.push_back({p.x(), p.y(), p.z(), field.empty() ? 0 : field[i]});
    }
    for (const BodyModel& body : model.bodies)
      if (body.surface)
        for (const Vector3& p : body.surface->vertices) vertices.push_back({p.x(), p.y(), p.z(), p.y()});
    particle = device->allocate("particle", Type::real4, particles.size());
    device->upload(particle, std::span<const Real4<double>>(particles));
    if (vertices.empty()) return;
    vertex = device->allocate("vertex", Type::real4, vertices.size());
    device->upload(vertex, std::span<const Real4<double>>(vertices));
  }
  RenderState state(double time = 0) const { return {particle, vertex, time}; }
  std::unique_ptr<Renderer> renderer(const std::string& label = "") const {
    return make_renderer(*device, scene, model, label);
  }
};

/// Points of a lattice inside a sphere.
inline std::vector<Vector3> ball(const Vector3& centre, double radius, double spacing) {
  std::vector<Vector3> points;
  const int n = static_cast<int>(radius / spacing) + 1;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x)
        if (const Vector3 p = spacing * Vector3(x, y, z); p.norm() <= radius) points.push_back(centre + p);
  return points;
}

/// A sphere of rings and segments, closed, seen from outside counter-clockwise.
inline Mesh globe(const Vector3& centre, double radius, unsigned rings = 24) {
  Mesh mesh;
  const unsigned segments = 2 * rings;
  const double pi = 3.14159265358979323846;
  mesh.vertices.push_back(centre + Vector3(0, radius, 0));
  for (unsigned r = 1; r < rings; ++r)
    for (unsigned s = 0; s < segments; ++s) {
      const double a = pi * r / rings, b = 2 * pi * s / segments;
      mesh.vertices.push_back(
          centre + radius * Vector3(std::sin(a) * std::sin(b), std::cos(a), std::sin(a) * std::cos(b)));
    }
  mesh.vertices.push_back(centre - Vector3(0, radius, 0));
  const auto at = [&](unsigned r, unsigned s) { return 1 + (r - 1) * segments + s % segments; };
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (unsigned s = 0; s < segments; ++s) {
    mesh.triangles.push_back({0, at(1, s), at(1, s + 1)});
    mesh.triangles.push_back({last, at(rings - 1, s + 1), at(rings - 1, s)});
    for (unsigned r = 1; r + 1 < rings; ++r) {
      mesh.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      mesh.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  }
  return mesh;
}

inline std::array<int, 3> pixel(const Image& image, double x, double y) {
  const std::uint8_t* p = image.at(static_cast<unsigned>(x), static_cast<unsigned>(y));
  return {p[0], p[1], p[2]};
}
inline double brightness(const std::array<int, 3>& p) {
  return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
}

/// Keeps a picture for people where PLIANT_TEST_PICTURES names a folder.
inline void keep(const Image& image, const std::string& name) {
  if (const char* folder = std::getenv("PLIANT_TEST_PICTURES"))
    write_png(image, std::filesystem::path(folder) / ("render-" + name + ".png"));
}

} // namespace pliant::test
