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

} // namespace pliant
