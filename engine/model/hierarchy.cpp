// Builds the coarse levels.
#include "engine/model/hierarchy.h"

#include "engine/model/lame.h"
#include "engine/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <unordered_map>

namespace pliant {

namespace {

using Place = std::array<int, 3>;
struct Key {
  std::uint32_t body;
  int z, y, x;
  auto operator<=>(const Key&) const = default; // NOLINT(modernize-use-nullptr): of the defaulted comparison
};

/// Capped: a material that only sheets have may have a ratio that no solid could have.
Lame constants_of(const Material& material, Neighbourhood neighbourhood) {
  const SmallStrain real = small_strain(material);
  const double most = neighbourhood == Neighbourhood::solid ? 0.499 : 0.95;
  return lame_constants(real.young, std::min(real.poisson, most), neighbourhood);
}

Vector3 corner(int a) {
  return {double(a & 1), double(a >> 1 & 1), double(a >> 2)};
}
double shape(int a, const Vector3& x) {
  double value = 1;
  for (int k = 0; k < 3; ++k) value *= a >> k & 1 ? x[k] : 1 - x[k];
  return value;
}
Vector3 slope(int a, const Vector3& x) {
  Vector3 g = Vector3::Ones();
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < 3; ++d) g[d] *= d == k ? (a >> k & 1 ? 1.0 : -1.0) : (a >> k & 1 ? x[k] : 1 - x[k]);
  return g;
}

/// Rows of 16 gathers a slice of 16 nodes, as bonds are stored.
struct Gathers {
  std::vector<std::vector<std::pair<std::uint32_t, double>>> of; ///< a level's nodes
};

class Builder {
public:
  Builder(const Scene& scene, const Model& model) : model_(model), n_(model.count()) {
    for (const Material& material : scene.materials)
      constants_.push_back(constants_of(material, Neighbourhood::solid));
    for (const std::uint32_t typed : model.sheet_material)
      constants_.push_back(constants_of(scene.materials[typed], Neighbourhood::plane_stress));
    mass_ = model.mass;
    hold(scene);
    place_.resize(n_);
    for (const BodyModel& body : model.bodies) {
      Vector3 low = Vector3::Constant(1e300);
      for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
        low = low.cwiseMin(model.reference[i]);
      for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
        place_[i] = ((model.reference[i] - low) / model.spacing).array() + 0.5;
    }
  }

  Hierarchy build() {
    if (n_ == 0) return {};
    h_.particle_node.assign((n_ + 15) / 16 * 128, 0);
    h_.particle_weight.assign((n_ + 15) / 16 * 128, 0);
    h_.gather_begin.push_back(0);
    const auto bodies = std::count_if(model_.bodies.begin(), model_.bodies.end(),
                                      [](const BodyModel& body) { return body.count > 0; });
    h_.blocks = static_cast<std::uint32_t>(bodies);
    for (int size = 2; level(size) > h_.blocks; size *= 2) {
    }
    h_.child_begin.push_back(static_cast<std::uint32_t>(h_.child.size()));
    return std::move(h_);
  }

private:
  /// What is held to the end has no share in a direction: it counts as so heavy that its inertia over a step
  /// is `anchor` of its bonds' stiffness. Free to the coarse levels, a body held at one end would answer to a
  /// smooth residual with a flight. The condition number of a held bar (tests/physics/multilevel.cpp) is
  /// least, 47, at 0.1: 89 at 0.02, 87 at 1, where the particles beside the held ones are stopped with them;
  /// 44,000 at none.
  void hold(const Scene& scene) {
    if (model_.held.empty()) return;
    constexpr double anchor = 0.1;
    const double step = scene.simulation.time_step;
    const std::vector<double> stiffness = diagonal_stiffness(model_);
    for (const Held& held : model_.held) {
      const Motion& motion = model_.motions[held.motion];
      if (!motion.release.value_or(false) || motion.end >= scene.simulation.end)
        mass_[held.particle] += anchor * step * step * stiffness[held.particle];
    }
  }

  /// Cells and nodes of one size; returns how many cells.
  std::size_t level(int size) {
    HierarchyLevel level;
    level.first_node = h_.nodes;
    level.first_cell = h_.cells;
    level.first_gather = static_cast<std::uint32_t>(h_.gather_begin.size() - 1);
    const bool finest = h_.levels.empty();
    std::map<Key, std::uint32_t> cell_at, node_at;
    std::vector<std::uint32_t> cell_of(n_);
    for (std::uint32_t i = 0; i < n_; ++i) cell_at[cell_key(i, size)] = 0;
    std::vector<Key> cells;
    for (auto& [key, index] : cell_at) {
      index = static_cast<std::uint32_t>(cells.size());
      cells.push_back(key);
      for (int a = 0; a < 8; ++a)
        node_at[{key.body, key.z + (a >> 2), key.y + (a >> 1 & 1), key.x + (a & 1)}] = 0;
    }
    std::vector<Key> nodes;
    for (auto& [key, index] : node_at) {
      index = static_cast<std::uint32_t>(nodes.size());
      nodes.push_back(key);
    }
    level.cells = static_cast<std::uint32_t>(cells.size());
    level.nodes = static_cast<std::uint32_t>(nodes.size());
    std::vector<std::vector<std::uint32_t>> inside(cells.size());
    for (std::uint32_t i = 0; i < n_; ++i) {
      cell_of[i] = cell_at.at(cell_key(i, size));
      inside[cell_of[i]].push_back(i);
    }
    tables(size, inside, cells);
    children(finest, inside, cells, cell_at);
    connect(level, nodes, node_at, cell_at);
    Gathers gathers;
    gathers.of.resize(nodes.size());
    const auto node = [&](const Key& key) { return level.first_node + node_at.at(key); };
    if (finest) {
      for (std::uint32_t i = 0; i < n_; ++i) {
        const Key c = cells[cell_of[i]];
        const Vector3 x = within(i, size, c);
        for (int a = 0; a < 8; ++a) {
          const Key key{c.body, c.z + (a >> 2), c.y + (a >> 1 & 1), c.x + (a & 1)};
          const double weight = shape(a, x);
          const std::size_t at = (i / 16 * 8 + static_cast<std::size_t>(a)) * 16 + i % 16;
          h_.particle_node[at] = node(key);
          h_.particle_weight[at] = weight;
          gathers.of[node_at.at(key)].emplace_back(i, weight);
        }
      }
    } else {
      parents(level, node_at, gathers);
    }
    append(gathers, finest ? 0 : h_.levels.back().first_node);
    h_.nodes += (level.nodes + 15) / 16 * 16;
    h_.cells += level.cells;
    h_.node_parent.resize(std::size_t{h_.nodes} * 8, 0);
    h_.parent_weight.resize(std::size_t{h_.nodes} * 8, 0);
    h_.levels.push_back(level);
    finer_nodes_ = std::move(nodes);
    finer_cells_ = std::move(cells);
    return level.cells;
  }

  Key cell_key(std::uint32_t i, int size) const {
    const Vector3 c = (place_[i] / size).array().floor();
    return {model_.body[i], int(c.z()), int(c.y()), int(c.x())};
  }
  Vector3 within(std::uint32_t i, int size, const Key& c) const {
    return place_[i] / size - Vector3(c.x, c.y, c.z);
  }

  /// One table for all cells that hold the same matter in the same places.
  void tables(int size, const std::vector<std::vector<std::uint32_t>>& inside,
              const std::vector<Key>& cells) {
    std::unordered_map<std::string, std::uint32_t> known;
    for (std::size_t c = 0; c < inside.size(); ++c) {
      std::string key;
      const auto put = [&key](double value) {
        key.append(reinterpret_cast<const char*>(&value), sizeof value);
      };
      for (std::uint32_t i : inside[c]) {
        const Vector3 x = within(i, size, cells[c]);
        for (int k = 0; k < 3; ++k) put(std::round(x[k] * 4096));
        put(model_.volume[i]);
        put(mass_[i]);
        put(model_.material[i]);
      }
      const auto [found, fresh] = known.try_emplace(key, h_.signatures);
      h_.signature.push_back(found->second);
      if (!fresh) continue;
      ++h_.signatures;
      const std::size_t first = h_.stiffness.size();
      h_.stiffness.resize(first + Hierarchy::table_size, 0);
      double mu_volume = 0, lambda_volume = 0;
      for (std::uint32_t i : inside[c])
        add_particle(i, size, within(i, size, cells[c]), &h_.stiffness[first]);
      for (std::uint32_t i : inside[c]) {
        mu_volume += constants_[model_.material[i]].mu * model_.volume[i];
        lambda_volume += constants_[model_.material[i]].lambda * model_.volume[i];
      }
      for (std::size_t ab = 0; ab < 64; ++ab)
        h_.stiffness[first + 12 * ab + 10] = mu_volume > 0 ? lambda_volume / mu_volume : 0;
    }
  }

  /// A particle is a cube of one spacing: its stiffness is the mean over its corners.
  void add_particle(std::uint32_t i, int size, const Vector3& x, double* table) const {
    const double weight = constants_[model_.material[i]].mu * model_.volume[i] / 8,
                 width = size * model_.spacing;
    for (int q = 0; q < 8; ++q) {
      const Vector3 at = x + (corner(q) - Vector3::Constant(0.5)) / size;
      std::array<Vector3, 8> g;
      for (int a = 0; a < 8; ++a) g[static_cast<std::size_t>(a)] = slope(a, at) / width;
      for (std::size_t a = 0; a < 8; ++a)
        for (std::size_t b = 0; b < 8; ++b)
          for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
              table[12 * (8 * a + b) + std::size_t(3 * r + c)] += weight * g[a][r] * g[b][c];
    }
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) table[12 * (8 * a + b) + 9] += mass_[i] * shape(a, x) * shape(b, x);
  }

  void children(bool finest, const std::vector<std::vector<std::uint32_t>>& inside,
                const std::vector<Key>& cells, const std::map<Key, std::uint32_t>& cell_at) {
    if (finest) {
      for (const auto& particles : inside) {
        h_.child_begin.push_back(static_cast<std::uint32_t>(h_.child.size()));
        h_.child.insert(h_.child.end(), particles.begin(), particles.end());
      }
      return;
    }
    std::vector<std::vector<std::uint32_t>> in(cells.size());
    for (std::uint32_t c = 0; c < finer_cells_.size(); ++c) {
      const Key& f = finer_cells_[c];
      in[cell_at.at({f.body, f.z / 2, f.y / 2, f.x / 2})].push_back(h_.levels.back().first_cell + c);
    }
    for (const auto& list : in) {
      h_.child_begin.push_back(static_cast<std::uint32_t>(h_.child.size()));
      h_.child.insert(h_.child.end(), list.begin(), list.end());
    }
  }

  void connect(const HierarchyLevel& level, const std::vector<Key>& nodes,
               const std::map<Key, std::uint32_t>& node_at, const std::map<Key, std::uint32_t>& cell_at) {
    const std::size_t padded = (nodes.size() + 15) / 16 * 16;
    const std::size_t first = h_.neighbour.size(), first_cell = h_.cell.size();
    h_.neighbour.resize(first + 27 * padded);
    h_.cell.resize(first_cell + 8 * padded, Hierarchy::no_cell);
    for (std::size_t p = 0; p < padded; ++p) {
      const std::size_t slice = p / 16, lane = p % 16;
      for (int k = 0; k < 27; ++k) {
        std::uint32_t other = level.first_node + static_cast<std::uint32_t>(p);
        if (p < nodes.size()) {
          const Key& n = nodes[p];
          const auto found = node_at.find({n.body, n.z + k / 9 - 1, n.y + k / 3 % 3 - 1, n.x + k % 3 - 1});
          if (found != node_at.end()) other = level.first_node + found->second;
        }
        h_.neighbour[first + (slice * 27 + static_cast<std::size_t>(k)) * 16 + lane] = other;
      }
      for (int c = 0; c < 8 && p < nodes.size(); ++c) {
        const Key& n = nodes[p];
        const auto found =
            cell_at.find({n.body, n.z - 1 + (c >> 2), n.y - 1 + (c >> 1 & 1), n.x - 1 + (c & 1)});
        if (found != cell_at.end())
          h_.cell[first_cell + (slice * 8 + static_cast<std::size_t>(c)) * 16 + lane] =
              level.first_cell + found->second;
      }
    }
  }

  /// A node of the level below lies on a coarse node, an edge, a face or the middle of a cell.
  void parents(const HierarchyLevel& level, const std::map<Key, std::uint32_t>& node_at, Gathers& gathers) {
    const std::uint32_t finer = h_.levels.back().first_node;
    for (std::uint32_t f = 0; f < finer_nodes_.size(); ++f) {
      const Key& n = finer_nodes_[f];
      std::size_t slot = 0;
      for (int a = 0; a < 8; ++a) {
        const int up[3] = {a & 1, a >> 1 & 1, a >> 2}, at[3] = {n.x, n.y, n.z};
        int coarse[3];
        double weight = 1;
        for (int k = 0; k < 3; ++k) {
          const bool odd = at[k] % 2 != 0;
          coarse[k] = at[k] / 2 + up[k];
          weight *= odd ? 0.5 : up[k] ? 0 : 1;
        }
        if (weight == 0) continue;
        const auto found = node_at.find({n.body, coarse[2], coarse[1], coarse[0]});
        if (found == node_at.end()) continue;
        const std::uint32_t global = finer + f;
        const std::size_t entry = (global / 16 * std::size_t{8} + slot++) * 16 + global % 16;
        h_.node_parent[entry] = level.first_node + found->second;
        h_.parent_weight[entry] = weight;
        gathers.of[found->second].emplace_back(global, weight);
      }
    }
  }

  void append(const Gathers& gathers, std::uint32_t filler) {
    for (std::size_t slice = 0; slice < (gathers.of.size() + 15) / 16; ++slice) {
      std::size_t rows = 0;
      for (std::size_t p = 16 * slice; p < std::min(16 * slice + 16, gathers.of.size()); ++p)
        rows = std::max(rows, gathers.of[p].size());
      const std::size_t first = h_.gather.size();
      h_.gather.resize(first + 16 * rows, filler);
      h_.gather_weight.resize(first + 16 * rows, 0);
      for (std::size_t p = 16 * slice; p < std::min(16 * slice + 16, gathers.of.size()); ++p)
        for (std::size_t k = 0; k < gathers.of[p].size(); ++k) {
          h_.gather[first + 16 * k + p % 16] = gathers.of[p][k].first;
          h_.gather_weight[first + 16 * k + p % 16] = gathers.of[p][k].second;
        }
      h_.gather_begin.push_back(static_cast<std::uint32_t>(h_.gather.size() / 16));
    }
  }

  const Model& model_;
  std::size_t n_;
  std::vector<Lame> constants_;
  std::vector<double> mass_;   ///< kg, see hold()
  std::vector<Vector3> place_; ///< in spacings, from half a spacing below the body's lowest corner
  std::vector<Key> finer_nodes_, finer_cells_;
  Hierarchy h_;
};

} // namespace

Hierarchy build_hierarchy(const Scene& scene, const Model& model) {
  return Builder(scene, model).build();
}

} // namespace pliant
