// Crossing triangles: a tree of boxes against itself, then the interval test of Guigue & Devillers (2003) on
// exact orientation signs.
#include "engine/scene/mesh_cross.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// A sum of doubles that is kept exactly, as parts that do not overlap, smallest first (Shewchuk 1997).
class ExactSum {
public:
  void add(double value) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const double sum = value + parts_[i], other = sum - value;
      const double error = (value - (sum - other)) + (parts_[i] - other);
      if (error != 0) parts_[kept++] = error;
      value = sum;
    }
    if (value != 0) parts_[kept++] = value;
    size_ = kept;
  }
  /// Adds sign * a * b * c.
  void add_product(double sign, double a, double b, double c) {
    const double high = a * b, low = std::fma(a, b, -high);
    for (const double part : {high * sign, low * sign}) {
      const double product = part * c;
      add(product);
      add(std::fma(part, c, -product));
    }
  }
  void add_determinant(double sign, const Vector3& a, const Vector3& b, const Vector3& c) {
    for (int k = 0; k < 3; ++k) {
      add_product(sign, a[k], b[(k + 1) % 3], c[(k + 2) % 3]);
      add_product(-sign, a[k], b[(k + 2) % 3], c[(k + 1) % 3]);
    }
  }
  int sign() const { return size_ == 0 ? 0 : parts_[size_ - 1] > 0 ? 1 : -1; }

private:
  std::array<double, 100> parts_; // 24 products of four parts each
  std::size_t size_ = 0;
};

int orientation_exact(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  ExactSum sum;
  sum.add_determinant(1, a, b, c);
  sum.add_determinant(-1, a, b, d);
  sum.add_determinant(1, a, c, d);
  sum.add_determinant(-1, b, c, d);
  return sum.sign();
}

/// Coplanar triangles, flattened along the longest component of their normal: no edge of either separates
/// them.
bool coplanar_overlap(const Corners& p, const Corners& q) {
  const Vector3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
  int axis = 0;
  if (normal.cwiseAbs().maxCoeff(&axis) == 0) return false;
  // With a point off the plane the sign of an area becomes the sign of a volume, which is exact.
  Vector3 apex = p[0];
  apex[axis] += normal[axis] > 0 ? 1.0 + std::abs(apex[axis]) : -1.0 - std::abs(apex[axis]);
  const auto separates = [&](const Corners& from, const Corners& other) {
    const int turn = orientation(from[0], from[1], from[2], apex);
    if (turn == 0) return true; // no area
    for (std::size_t k = 0; k < 3; ++k)
      if (std::all_of(other.begin(), other.end(), [&](const Vector3& v) {
            return turn * orientation(from[k], from[(k + 1) % 3], v, apex) <= 0;
          }))
        return true;
    return false;
  };
  return !separates(p, q) && !separates(q, p);
}

/// Turns a triangle so that its first corner is alone on its side of the other's plane; false where it is not
/// split.
bool corner_alone(Corners& t, std::array<int, 3> signs, int& side) {
  if (*std::min_element(signs.begin(), signs.end()) >= 0 ||
      *std::max_element(signs.begin(), signs.end()) <= 0)
    return false;
  for (std::size_t k = 0; k < 3; ++k) {
    if (signs[k] == 0 || signs[k] == signs[(k + 1) % 3] || signs[k] == signs[(k + 2) % 3]) continue;
    t = {t[k], t[(k + 1) % 3], t[(k + 2) % 3]};
    side = signs[k];
    return true;
  }
  return false;
}

struct Finder {
  const TriangleTree& tree;
  const Mesh& mesh;
  std::size_t found = 0;

  void pair(std::uint32_t i, std::uint32_t j) {
    const Corners &p = tree.corners[i], &q = tree.corners[j];
    for (int k = 0; k < 3; ++k)
      if (std::max({p[0][k], p[1][k], p[2][k]}) < std::min({q[0][k], q[1][k], q[2][k]}) ||
          std::max({q[0][k], q[1][k], q[2][k]}) < std::min({p[0][k], p[1][k], p[2][k]}))
        return;
    for (const Vector3& a : p)
      for (const Vector3& b : q)
        if (a == b) return; // the same vertex, or one at the same place
    found += triangles_cross(p, q);
  }

  /// All pairs of a triangle below node a with one below node b; a == b: each pair once.
  void descend(std::uint32_t a, std::uint32_t b) {
    const TriangleTree::Node &m = tree.nodes[a], &n = tree.nodes[b];
    if ((m.low.array() > n.high.array()).any() || (n.low.array() > m.high.array()).any()) return;
    if (!m.second && !n.second) {
      for (std::uint32_t i = m.first; i < m.first + m.count; ++i)
        for (std::uint32_t j = a == b ? i + 1 : n.first; j < n.first + n.count; ++j) pair(i, j);
    } else if (a == b) {
      descend(a + 1, a + 1);
      descend(m.second, m.second);
      descend(a + 1, m.second);
    } else if (m.second && (!n.second || m.count >= n.count)) {
      descend(a + 1, b);
      descend(m.second, b);
    } else {
      descend(a, b + 1);
      descend(a, n.second);
    }
  }
};

} // namespace

int orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const Vector3 u = a - d, v = b - d, w = c - d;
  double determinant = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    const double one = v[(k + 1) % 3] * w[(k + 2) % 3], two = v[(k + 2) % 3] * w[(k + 1) % 3];
    determinant += u[k] * (one - two);
    size += std::abs(u[k]) * (std::abs(one) + std::abs(two));
  }
  constexpr double bound = 8e-16; // (7 + 56 e) e with e = 2^-53
  if (determinant > bound * size) return 1;
  if (determinant < -bound * size) return -1;
  return size == 0 ? 0 : orientation_exact(a, b, c, d);
}

bool triangles_cross(const Corners& p_given, const Corners& q_given) {
  Corners p = p_given, q = q_given;
  const auto signs = [](const Corners& plane, const Corners& t) {
    return std::array<int, 3>{orientation(plane[0], plane[1], plane[2], t[0]),
                              orientation(plane[0], plane[1], plane[2], t[1]),
                              orientation(plane[0], plane[1], plane[2], t[2])};
  };
  const std::array<int, 3> of_p = signs(q, p);
  if (of_p == std::array<int, 3>{0, 0, 0}) return coplanar_overlap(p, q);
  int p_side = 0, q_side = 0;
  if (!corner_alone(p, of_p, p_side) || !corner_alone(q, signs(p_given, q), q_side)) return false;
  // Both are cut by the line in which their planes meet. Turned so that each lone corner is on the positive
  // side, the two open intervals on that line overlap where these signs agree.
  if (p_side < 0) std::swap(q[1], q[2]);
  if (q_side < 0) std::swap(p[1], p[2]);
  return orientation(p[0], p[1], q[0], q[1]) < 0 && orientation(p[0], p[2], q[2], q[0]) < 0;
}

std::size_t count_crossing_pairs(const Mesh& mesh) {
  const TriangleTree tree(mesh, 4);
  Finder finder{tree, mesh};
  if (!tree.nodes.empty()) finder.descend(0, 0);
  return finder.found;
}

} // namespace pliant
