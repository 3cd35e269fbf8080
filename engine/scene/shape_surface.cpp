// Analytic shapes as triangles.
#include "engine/scene/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace pliant {
namespace {

constexpr double triangle_limit = 20000; // a surface to draw and skin; more would cost more than they show

std::uint32_t cells_of(double length, double spacing, double least, double most) {
  return static_cast<std::uint32_t>(std::clamp(std::round(length / spacing), least, most));
}

/// The profile (distance from the y axis, height), counter-clockwise with the axis at the left, turned about
/// y. An open profile begins and ends on the axis.
Mesh revolve(const std::vector<std::array<double, 2>>& profile, bool closed, std::uint32_t around) {
  Mesh mesh;
  std::vector<std::uint32_t> first; // vertex of each point of the profile; a point on the axis is one vertex
  for (const auto& [radius, height] : profile) {
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    for (std::uint32_t k = 0; k < (radius == 0 ? 1 : around); ++k) {
      const double angle = 2 * std::numbers::pi * k / around;
      mesh.vertices.emplace_back(radius * std::cos(angle), height, radius * std::sin(angle));
    }
  }
  for (std::size_t i = 0; i + (closed ? 0 : 1) < profile.size(); ++i) {
    const std::size_t j = (i + 1) % profile.size();
    for (std::uint32_t k = 0; k < around; ++k) {
      const std::uint32_t l = (k + 1) % around;
      const bool from_axis = profile[i][0] == 0, to_axis = profile[j][0] == 0;
      if (!to_axis) mesh.triangles.push_back({first[i] + (from_axis ? 0 : k), first[j] + k, first[j] + l});
      if (!from_axis) mesh.triangles.push_back({first[i] + k, first[j] + (to_axis ? 0 : l), first[i] + l});
    }
  }
  return mesh;
}

} // namespace

Mesh triangulate_box(const Vector3& size, const std::array<std::uint32_t, 3>& cells) {
  Mesh mesh;
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> numbers(std::size_t{cells[0] + 1} * (cells[1] + 1) * (cells[2] + 1), none);
  const auto vertex = [&](const std::array<std::uint32_t, 3>& at) {
    std::uint32_t& number = numbers[(std::size_t{at[2]} * (cells[1] + 1) + at[1]) * (cells[0] + 1) + at[0]];
    if (number == none) {
      number = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.emplace_back(size[0] * (double(at[0]) / cells[0] - 0.5),
                                 size[1] * (double(at[1]) / cells[1] - 0.5),
                                 size[2] * (double(at[2]) / cells[2] - 0.5));
    }
    return number;
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
    for (const std::uint32_t level : {0u, cells[k]})
      for (std::uint32_t j = 0; j < cells[v]; ++j)
        for (std::uint32_t i = 0; i < cells[u]; ++i) {
          std::array<std::uint32_t, 4> corner{};
          for (std::uint32_t c = 0; c < 4; ++c) {
            std::array<std::uint32_t, 3> at{};
            at[k] = level;
            at[u] = i + (c == 1 || c == 2);
            at[v] = j + (c >= 2);
            corner[c] = vertex(at);
          }
          if (level == 0) std::swap(corner[1], corner[3]);
          const std::uint32_t turn = (i + j) % 2; // diagonals alternate, so that no direction is preferred
          mesh.triangles.push_back({corner[turn], corner[turn + 1], corner[turn + 2]});
          mesh.triangles.push_back({corner[turn], corner[turn + 2], corner[(turn + 3) % 4]});
        }
  }
  return mesh;
}

Mesh triangulate_sphere(double radius, std::uint32_t cells) {
  Mesh mesh = triangulate_box({2, 2, 2}, {cells, cells, cells});
  for (Vector3& v : mesh.vertices) { // tangents make the angles between the lines of a face equal
    for (int k = 0; k < 3; ++k) v[k] = std::tan(std::numbers::pi / 4 * v[k]);
    v *= radius / v.norm();
  }
  return mesh;
}

Mesh triangulate_cylinder(double radius, double height, std::uint32_t around, std::uint32_t rows,
                          std::uint32_t rings) {
  std::vector<std::array<double, 2>> profile;
  for (std::uint32_t i = 0; i < rings; ++i) profile.push_back({radius * i / rings, -height / 2});
  for (std::uint32_t i = 0; i < rows; ++i) profile.push_back({radius, height * (double(i) / rows - 0.5)});
  for (std::uint32_t i = 0; i <= rings; ++i) profile.push_back({radius * (rings - i) / rings, height / 2});
  return revolve(profile, false, around);
}

Mesh triangulate_torus(double radius, double tube, std::uint32_t around, std::uint32_t around_tube) {
  std::vector<std::array<double, 2>> profile;
  for (std::uint32_t i = 0; i < around_tube; ++i) {
    const double angle = 2 * std::numbers::pi * i / around_tube;
    profile.push_back({radius + tube * std::cos(angle), tube * std::sin(angle)});
  }
  return revolve(profile, true, around);
}

Mesh triangulate_rectangle(double width, double height, double edge) {
  const std::uint32_t columns = cells_of(width, edge, 1, triangle_limit / 2),
                      rows = cells_of(height, edge, 1, triangle_limit / 2);
  Mesh mesh;
  for (std::uint32_t j = 0; j <= rows; ++j)
    for (std::uint32_t i = 0; i <= columns; ++i)
      mesh.vertices.emplace_back(width * (double(i) / columns - 0.5), height * (double(j) / rows - 0.5), 0);
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * (columns + 1) + i, b = a + 1, c = b + columns + 1, d = c - 1;
      if ((i + j) % 2 == 0) { // diagonals alternate, so that no direction is preferred
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, c, d});
      }
    }
  return mesh;
}

Mesh triangulate_disc(double radius, std::uint32_t around, std::uint32_t rings) {
  std::vector<std::array<double, 2>> profile;
  for (std::uint32_t i = 0; i <= rings; ++i) profile.push_back({radius * (rings - i) / rings, 0});
  Mesh mesh = revolve(profile, false, around);
  for (Vector3& v : mesh.vertices) v = {v.x(), -v.z(), 0};
  return mesh;
}

Mesh surface_of(const PlacedShape& placed, double spacing) {
  const Shape& s = placed.shape;
  const double turn = 2 * std::numbers::pi;
  Mesh mesh;
  switch (s.kind) {
  case Shape::Kind::box: {
    const Vector3& a = s.size;
    const double triangles = 4 * (a[0] * a[1] + a[1] * a[2] + a[2] * a[0]) / (spacing * spacing);
    const double edge = spacing * std::sqrt(std::max(1.0, triangles / triangle_limit));
    const auto cells = [&](double length) { return cells_of(length, edge, 1, triangle_limit / 8); };
    mesh = triangulate_box(a, {cells(a[0]), cells(a[1]), cells(a[2])});
    break;
  }
  case Shape::Kind::sphere:
    mesh = triangulate_sphere(s.radius, 16);
    break;
  case Shape::Kind::cylinder: {
    const std::uint32_t around = cells_of(turn * s.radius, spacing, 24, 96),
                        rings = cells_of(s.radius, spacing, 1, 16);
    const double most = triangle_limit / (2 * around) - 2 * rings;
    mesh = triangulate_cylinder(s.radius, s.height, around, cells_of(s.height, spacing, 1, most), rings);
    break;
  }
  case Shape::Kind::torus: {
    const std::uint32_t tube = cells_of(turn * s.tube, spacing, 16, 64);
    mesh = triangulate_torus(s.radius, s.tube,
                             cells_of(turn * s.radius, spacing, 32, triangle_limit / (2 * tube)), tube);
    break;
  }
  case Shape::Kind::mesh:
    mesh = placed.mesh;
    break;
  case Shape::Kind::sheet:
    mesh =
        triangulate_rectangle(s.sheet->at(0), s.sheet->at(1),
                              spacing * std::sqrt(std::max(1.0, 2 * s.sheet->at(0) * s.sheet->at(1) /
                                                                    (spacing * spacing * triangle_limit))));
    break;
  case Shape::Kind::plane:
    break;
  }
  for (Vector3& v : mesh.vertices) v = placed.to_world(v);
  return mesh;
}

} // namespace pliant
