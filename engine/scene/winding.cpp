// Inside or outside, and how far: the generalised winding number (Jacobson, Kavan & Sorkine-Hornung 2013) by
// a tree of dipoles (Barill, Dickson, Schmidt, Levin & Jacobson 2018), and the distance, by a tree of boxes.
#include "engine/scene/winding.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace pliant {
namespace {

constexpr std::uint32_t leaf_size = 4; // triangles; more make the tree smaller and near queries slower

struct Builder {
  TriangleTree& tree;
  const std::vector<Vector3>& centroids;
  const std::vector<Corners>& corners;
  std::uint32_t leaf;

  std::uint32_t build(std::uint32_t first, std::uint32_t count) {
    const auto index = static_cast<std::uint32_t>(tree.nodes.size());
    TriangleTree::Node node;
    node.first = first;
    node.count = count;
    node.low.setConstant(std::numeric_limits<double>::infinity());
    node.high = -node.low;
    Vector3 low = node.low, high = node.high;
    for (std::uint32_t i = first; i < first + count; ++i) {
      for (const Vector3& corner : corners[tree.order[i]]) {
        node.low = node.low.cwiseMin(corner);
        node.high = node.high.cwiseMax(corner);
      }
      low = low.cwiseMin(centroids[tree.order[i]]);
      high = high.cwiseMax(centroids[tree.order[i]]);
    }
    tree.nodes.push_back(node);
    if (count <= leaf) return index;
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const auto begin = tree.order.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t a, std::uint32_t b) {
      const double x = centroids[a][axis], y = centroids[b][axis];
      return x < y || (x == y && a < b);
    });
    build(first, count / 2);
    tree.nodes[index].second = build(first + count / 2, count - count / 2);
    return index;
  }
};

/// The triangles of a node as a multipole at their centre p: with a the area, n the normal and d = x - p,
///   4 pi w(q) = sum over triangles of the integral of n . (x - q) / |x - q|^3,
/// expanded to second order in d about r = p - q:
///   N.r / r^3 + tr M / r^3 - 3 r.M r / r^5 - 3/2 v.r / r^5 + 15/2 T(r, r, r) / r^7
/// where N = sum a n, M = sum a d n^T, v = sum a (2 (d.n) d + |d|^2 n), T = sum a (d.r)^2 (n.r) as a cubic
/// form.
struct Dipole {
  Vector3 centre = Vector3::Zero();
  double radius = 0; ///< of a ball about the centre that holds the triangles
  Vector3 normal = Vector3::Zero(), v = Vector3::Zero();
  double trace = 0;
  std::array<double, 6> m{};  ///< xx yy zz xy yz zx of the quadratic form
  std::array<double, 10> t{}; ///< xxx yyy zzz xxy xxz yyx yyz zzx zzy xyz

  double operator()(const Vector3& q) const {
    const Vector3 r = centre - q;
    const double x = r[0], y = r[1], z = r[2], xx = x * x, yy = y * y, zz = z * z;
    const double i2 = 1 / (xx + yy + zz), i3 = i2 * std::sqrt(i2);
    const double quadratic = m[0] * xx + m[1] * yy + m[2] * zz + m[3] * x * y + m[4] * y * z + m[5] * z * x;
    const double cubic = (t[0] * x + t[3] * y + t[4] * z) * xx + (t[1] * y + t[5] * x + t[6] * z) * yy +
                         (t[2] * z + t[7] * x + t[8] * y) * zz + t[9] * x * y * z;
    return i3 * (normal.dot(r) + trace + i2 * (-3 * quadratic - 1.5 * v.dot(r) + 7.5 * i2 * cubic));
  }
};

/// Adds a point of weight a n at d from the centre.
void accumulate(Dipole& p, const Vector3& d, const Vector3& n) {
  p.trace += d.dot(n);
  p.v += 2 * d.dot(n) * d + d.squaredNorm() * n;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    p.m[k] += d[k] * n[k];
    p.m[3 + k] += d[k] * n[l] + d[l] * n[k];
    p.t[k] += d[k] * d[k] * n[k];
  }
  const auto aab = [&](int a, int b) { return d[a] * d[a] * n[b] + 2 * d[a] * d[b] * n[a]; };
  p.t[3] += aab(0, 1);
  p.t[4] += aab(0, 2);
  p.t[5] += aab(1, 0);
  p.t[6] += aab(1, 2);
  p.t[7] += aab(2, 0);
  p.t[8] += aab(2, 1);
  p.t[9] += 2 * (d[0] * d[1] * n[2] + d[1] * d[2] * n[0] + d[2] * d[0] * n[1]);
}

Dipole dipole_of(const Corners* triangles, std::size_t count) {
  Dipole p;
  double area = 0;
  Vector3 plain = Vector3::Zero(); // the centre should the triangles have no area
  for (std::size_t i = 0; i < count; ++i) {
    const Corners& t = triangles[i];
    const Vector3 normal = (t[1] - t[0]).cross(t[2] - t[0]) / 2, centroid = (t[0] + t[1] + t[2]) / 3;
    p.normal += normal;
    p.centre += normal.norm() * centroid;
    area += normal.norm();
    plain += centroid;
  }
  p.centre = area > 0 ? Vector3(p.centre / area) : Vector3(plain / static_cast<double>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const Corners& t = triangles[i];
    const Vector3 third = (t[1] - t[0]).cross(t[2] - t[0]) / 6;
    for (std::size_t k = 0; k < 3; ++k) { // the midpoints of the edges integrate quadratics exactly
      accumulate(p, (t[k] + t[(k + 1) % 3]) / 2 - p.centre, third);
      p.radius = std::max(p.radius, (t[k] - p.centre).norm());
    }
  }
  return p;
}

Vector3 nearest_on_segment(const Vector3& a, const Vector3& b, const Vector3& p) {
  const Vector3 ab = b - a;
  const double length = ab.squaredNorm();
  return length > 0 ? Vector3(a + std::clamp(ab.dot(p - a) / length, 0.0, 1.0) * ab) : a;
}

double squared_distance(const TriangleTree::Node& node, const Vector3& p) {
  return (node.low - p).cwiseMax(p - node.high).cwiseMax(0.0).squaredNorm();
}

} // namespace

TriangleTree::TriangleTree(const Mesh& mesh, std::uint32_t leaf) : order(mesh.triangles.size()) {
  std::vector<Corners> unordered;
  std::vector<Vector3> centroids;
  for (const auto& t : mesh.triangles) {
    unordered.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    centroids.push_back((unordered.back()[0] + unordered.back()[1] + unordered.back()[2]) / 3);
  }
  std::iota(order.begin(), order.end(), 0u);
  if (!order.empty())
    Builder{*this, centroids, unordered, leaf}.build(0, static_cast<std::uint32_t>(order.size()));
  for (const std::uint32_t t : order) corners.push_back(unordered[t]);
}

double solid_angle(const Corners& triangle, const Vector3& point) {
  const Vector3 a = triangle[0] - point, b = triangle[1] - point, c = triangle[2] - point;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double across = a.dot(b.cross(c)),
               along = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return across == 0 ? 0 : 2 * std::atan2(across, along); // in the triangle's plane: neither side
}

Vector3 nearest_on_triangle(const Corners& triangle, const Vector3& point) {
  const auto& [a, b, c] = triangle;
  const Vector3 normal = (b - a).cross(c - a);
  const double size = normal.squaredNorm();
  bool within = size > 0;
  for (std::size_t k = 0; k < 3 && within; ++k)
    within = normal.dot((triangle[(k + 1) % 3] - triangle[k]).cross(point - triangle[k])) >= 0;
  if (within) return point - normal * (normal.dot(point - a) / size);
  Vector3 best = nearest_on_segment(a, b, point);
  for (const Vector3& other : {nearest_on_segment(b, c, point), nearest_on_segment(c, a, point)})
    if ((other - point).squaredNorm() < (best - point).squaredNorm()) best = other;
  return best;
}

struct MeshQuery::Tree {
  TriangleTree boxes;
  std::vector<Dipole> dipoles;
};

MeshQuery::MeshQuery(const Mesh& mesh) : tree_(new Tree{TriangleTree(mesh, leaf_size), {}}) {
  const auto count = static_cast<std::ptrdiff_t>(tree_->boxes.nodes.size());
  tree_->dipoles.resize(tree_->boxes.nodes.size());
#pragma omp parallel for schedule(dynamic, 16)
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const TriangleTree::Node& node = tree_->boxes.nodes[i];
    tree_->dipoles[i] = dipole_of(tree_->boxes.corners.data() + node.first, node.count);
  }
}

MeshQuery::~MeshQuery() = default;
MeshQuery::MeshQuery(MeshQuery&&) noexcept = default;

double MeshQuery::winding_number(const Vector3& point, double beta) const {
  const auto& nodes = tree_->boxes.nodes;
  if (nodes.empty()) return 0;
  std::array<std::uint32_t, 64> waiting; // the tree is at most 32 deep
  std::size_t depth = 0;
  waiting[depth++] = 0;
  double sum = 0;
  while (depth > 0) {
    const std::uint32_t i = waiting[--depth];
    const Dipole& dipole = tree_->dipoles[i];
    const double reach = beta * dipole.radius;
    if ((dipole.centre - point).squaredNorm() > reach * reach) {
      sum += dipole(point);
    } else if (nodes[i].second) {
      waiting[depth++] = nodes[i].second;
      waiting[depth++] = i + 1;
    } else {
      for (std::uint32_t t = nodes[i].first; t < nodes[i].first + nodes[i].count; ++t)
        sum += solid_angle(tree_->boxes.corners[t], point);
    }
  }
  return sum / (4 * std::numbers::pi);
}

double MeshQuery::distance(const Vector3& point, Vector3* nearest) const {
  const auto& nodes = tree_->boxes.nodes;
  double best = std::numeric_limits<double>::infinity();
  if (nodes.empty()) return best;
  struct Waiting {
    std::uint32_t node;
    double least; ///< squared distance to its box
  };
  std::array<Waiting, 64> waiting;
  std::size_t depth = 0;
  waiting[depth++] = {0, squared_distance(nodes[0], point)};
  while (depth > 0) {
    const Waiting next = waiting[--depth];
    if (next.least >= best) continue;
    const TriangleTree::Node& node = nodes[next.node];
    if (node.second) {
      Waiting near{next.node + 1, squared_distance(nodes[next.node + 1], point)};
      Waiting far{node.second, squared_distance(nodes[node.second], point)};
      if (far.least < near.least) std::swap(near, far);
      waiting[depth++] = far;
      waiting[depth++] = near;
      continue;
    }
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
      const Vector3 candidate = nearest_on_triangle(tree_->boxes.corners[t], point);
      const double squared = (candidate - point).squaredNorm();
      if (squared >= best) continue;
      best = squared;
      if (nearest) *nearest = candidate;
    }
  }
  return std::sqrt(best);
}

} // namespace pliant
