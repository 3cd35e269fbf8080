// Whether a mesh bounds a solid, and what it measures.
#include "engine/scene/mesh_cross.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace pliant {
namespace {

/// An edge of a triangle: its ends in order, then whether the triangle runs from the larger to the smaller.
using Edge = std::array<std::uint32_t, 3>;

void count_edges(const Mesh& mesh, MeshReport& report) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue; // a needle: its edges cancel
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b ? 0u : 1u});
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0, j = 0; i < edges.size(); i = j) {
    std::size_t backward = 0;
    for (j = i; j < edges.size() && edges[j][0] == edges[i][0] && edges[j][1] == edges[i][1]; ++j)
      backward += edges[j][2];
    if (j - i == 1)
      ++report.open_edges;
    else if (j - i > 2 || backward != 1)
      ++report.odd_edges;
  }
}

} // namespace

MeshReport measure(const Mesh& mesh) {
  MeshReport report;
  if (mesh.vertices.empty() || mesh.triangles.empty()) return report;
  report.low = report.high = mesh.vertices[mesh.triangles[0][0]];
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      report.low = report.low.cwiseMin(mesh.vertices[v]);
      report.high = report.high.cwiseMax(mesh.vertices[v]);
    }
  const Vector3 middle = (report.low + report.high) / 2; // keeps the volume's terms small far from the origin
  for (const auto& t : mesh.triangles) {
    const Vector3 a = mesh.vertices[t[0]] - middle, b = mesh.vertices[t[1]] - middle,
                  c = mesh.vertices[t[2]] - middle;
    const Vector3 normal = (b - a).cross(c - a);
    const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if (normal.norm() <= 1e-12 * longest) ++report.degenerate;
    report.area += normal.norm() / 2;
    report.volume += a.dot(b.cross(c)) / 6;
  }
  count_edges(mesh, report);
  return report;
}

MeshReport examine(const Mesh& mesh) {
  MeshReport report = measure(mesh);
  report.crossing_pairs = count_crossing_pairs(mesh);
  return report;
}

} // namespace pliant
