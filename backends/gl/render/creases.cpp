// Groups the triangles around each vertex by the smooth edges between them.
#include "backends/gl/render/creases.h"

#include <Eigen/Geometry>

#include <cmath>
#include <numeric>

namespace pliant::gl {

DrawnMesh split_creases(const Mesh& mesh, double degrees) {
  DrawnMesh drawn;
  drawn.triangles = mesh.triangles;
  drawn.indices.resize(mesh.triangles.size());
  const double least = std::cos(degrees * 3.14159265358979323846 / 180);

  std::vector<Vector3> normals;
  std::vector<std::uint32_t> begin(mesh.vertices.size() + 1, 0);
  for (const auto& t : mesh.triangles) {
    const Vector3 cross =
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    normals.push_back(cross.normalized());
    for (const std::uint32_t v : t) ++begin[v + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> around(begin.back()), next(begin.begin(), begin.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) around[next[v]++] = t;

  // Triangles at v that share a second vertex share an edge.
  const auto adjacent = [&](std::uint32_t v, std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t p : mesh.triangles[a])
      for (const std::uint32_t q : mesh.triangles[b])
        if (p == q && p != v) return true;
    return false;
  };
  std::vector<std::uint32_t> group;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    std::vector<std::uint32_t> left(around.begin() + begin[v], around.begin() + begin[v + 1]);
    while (!left.empty()) {
      group.assign(1, left.back());
      left.pop_back();
      for (std::size_t k = 0; k < group.size(); ++k)
        for (std::size_t i = 0; i < left.size();) {
          if (normals[group[k]].dot(normals[left[i]]) >= least && adjacent(v, group[k], left[i])) {
            group.push_back(left[i]);
            left[i] = left.back();
            left.pop_back();
          } else {
            ++i;
          }
        }
      const auto first = static_cast<std::uint32_t>(drawn.fans.size());
      const auto corner = static_cast<std::uint32_t>(drawn.corners.size());
      drawn.fans.insert(drawn.fans.end(), group.begin(), group.end());
      drawn.corners.push_back({v, first, static_cast<std::uint32_t>(drawn.fans.size()), 0});
      for (const std::uint32_t t : group)
        for (int c = 0; c < 3; ++c)
          if (mesh.triangles[t][c] == v) drawn.indices[t][c] = corner;
    }
  }
  return drawn;
}

} // namespace pliant::gl
