// Ties the vertices of a carried mesh to the particles nearest to them at rest.
#include "engine/model/skin.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace pliant {

namespace {

constexpr std::size_t wanted = 5;

/// Particles of one body in cells of one spacing.
class Cells {
public:
  Cells(const Model& model, const BodyModel& body) : model_(model) {
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
      cells_[key(cell(model.reference[i]))].push_back(i);
  }

  /// At most `wanted` nearest particles, nearest first; ties by index.
  std::vector<std::pair<double, std::uint32_t>> nearest(const Vector3& x) const {
    std::vector<std::pair<double, std::uint32_t>> found;
    const Eigen::Vector3i middle = cell(x);
    // Rings of cells until the nearest are certain: whatever lies outside ring r is farther than r spacings.
    for (int ring = 1; ring <= 64; ++ring) {
      found.clear();
      for (int dz = -ring; dz <= ring; ++dz)
        for (int dy = -ring; dy <= ring; ++dy)
          for (int dx = -ring; dx <= ring; ++dx) {
            const auto cell = cells_.find(key(middle + Eigen::Vector3i(dx, dy, dz)));
            if (cell == cells_.end()) continue;
            for (std::uint32_t i : cell->second) found.emplace_back((model_.reference[i] - x).norm(), i);
          }
      std::sort(found.begin(), found.end());
      if (found.size() > wanted) found.resize(wanted);
      if (found.size() == wanted && found.back().first <= ring * model_.spacing) break;
    }
    return found;
  }

private:
  Eigen::Vector3i cell(const Vector3& x) const { return (x / model_.spacing).array().floor().cast<int>(); }
  static std::uint64_t key(const Eigen::Vector3i& c) {
    const auto part = [](int v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1fffff; };
    return part(c.x()) | part(c.y()) << 21 | part(c.z()) << 42;
  }

  const Model& model_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

/// At rest, m.
double longest_bond(const Model& model, const BodyModel& body) {
  double longest = 0;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
    for (std::uint32_t k = model.bonds.begin[i]; k < model.bonds.begin[i + 1]; ++k)
      longest = std::max(longest, (model.reference[model.bonds.neighbour[k]] - model.reference[i]).norm());
  return longest;
}

/// In how many pieces particles hang together that are linked where they are no further apart than `reach`.
std::uint32_t count_pieces(const Model& model, const std::vector<std::uint32_t>& particles, double reach) {
  std::vector<std::uint32_t> left(particles), piece;
  std::uint32_t pieces = 0;
  for (; !left.empty(); ++pieces) {
    piece.assign(1, left.back());
    left.pop_back();
    for (std::size_t k = 0; k < piece.size(); ++k)
      for (std::size_t i = 0; i < left.size();) {
        if ((model.reference[left[i]] - model.reference[piece[k]]).norm() <= reach * (1 + 1e-9)) {
          piece.push_back(left[i]);
          left[i] = left.back();
          left.pop_back();
        } else {
          ++i;
        }
      }
  }
  return pieces;
}

} // namespace

Skin make_skin(const Model& model) {
  Skin skin;
  for (const BodyModel& body : model.bodies) {
    skin.first.push_back(static_cast<std::uint32_t>(skin.particle.size()));
    if (!body.surface || body.count == 0) continue;
    const Cells cells(model, body);
    for (const Vector3& x : body.surface_reference) {
      const auto nearest = cells.nearest(x);
      const std::size_t count = std::min<std::size_t>(nearest.size(), 4);
      const double reach =
          nearest.size() == wanted ? nearest.back().first : 2 * nearest.back().first + model.spacing;
      std::uint32_t particle[4];
      double weight[4] = {0, 0, 0, 0}, sum = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        particle[k] = nearest[std::min(k, count - 1)].second;
        if (k >= count) continue;
        const double ratio = nearest[k].first / reach;
        weight[k] = std::pow(std::max(1 - ratio * ratio, 1e-6), 2);
        sum += weight[k];
      }
      skin.particle.push_back({particle[0], particle[1], particle[2], particle[3]});
      skin.weight.push_back({weight[0] / sum, weight[1] / sum, weight[2] / sum, weight[3] / sum});
      skin.reference.push_back({x.x(), x.y(), x.z(), 0});
    }
  }
  skin.first.push_back(static_cast<std::uint32_t>(skin.particle.size()));
  return skin;
}

SkinTriangles make_skin_triangles(const Model& model, const Skin& skin) {
  SkinTriangles made;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const BodyModel& body = model.bodies[b];
    made.first.push_back(static_cast<std::uint32_t>(made.triangle.size()));
    if (!body.surface || body.count == 0) continue;
    const double reach = longest_bond(model, body);
    for (const std::array<std::uint32_t, 3>& corner : body.surface->triangles) {
      const std::uint32_t v[] = {skin.first[b] + corner[0], skin.first[b] + corner[1],
                                 skin.first[b] + corner[2]};
      std::vector<std::uint32_t> particles;
      for (const std::uint32_t vertex : v) {
        const Uint4& nearest = skin.particle[vertex];
        particles.insert(particles.end(), {nearest.x, nearest.y, nearest.z, nearest.w});
      }
      std::sort(particles.begin(), particles.end());
      particles.erase(std::unique(particles.begin(), particles.end()), particles.end());
      made.triangle.push_back({v[0], v[1], v[2], count_pieces(model, particles, reach)});
    }
  }
  made.first.push_back(static_cast<std::uint32_t>(made.triangle.size()));
  return made;
}

} // namespace pliant
