// The coarse levels: cells and nodes of every shape of body, weights of interpolation and restriction, and
// the tables of the finite elements.
#include "engine/model/hierarchy.h"

#include "engine/scene/scene.h"
#include "tests/model/lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <queue>
#include <random>
#include <set>

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;
constexpr std::uint32_t none = Hierarchy::no_cell;

struct Built {
  Scene scene;
  Model model;
  Hierarchy h;
};

Built build(const std::vector<Vector3>& points, double poisson = 0.3) {
  Built built;
  built.scene.simulation.spacing = spacing;
  built.scene.materials = {material("corotated", 1e5, poisson)};
  built.model =
      assemble_points(points, spacing, 1.87, built.scene.materials[0], std::pow(spacing, 3), "normalised");
  built.h = build_hierarchy(built.scene, built.model);
  return built;
}

std::vector<Vector3> l_shape() {
  std::vector<Vector3> points;
  for (const Vector3& x : block(9, 8, 3, spacing))
    if (x.x() < 0.25 || x.y() < 0.25) points.push_back(x);
  return points;
}
std::vector<Vector3> irregular() {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  std::vector<Vector3> points = block(6, 5, 7, spacing);
  for (Vector3& x : points) x += spacing * Vector3(jitter(random), jitter(random), jitter(random));
  return points;
}
Built two_bodies() {
  Built built;
  built.scene.simulation.spacing = spacing;
  built.scene.materials = {material("corotated", 1e5, 0.3)};
  for (int k = 0; k < 2; ++k) {
    Body body;
    body.name = std::to_string(k);
    body.material = "corotated";
    body.shape.size = k ? Vector3(0.3, 0.2, 0.2) : Vector3(1.1, 0.4, 0.3);
    body.shape.at = Vector3(0, 2.0 * k, 0.05);
    body.shape.rotate_degrees = 40 * k;
    built.scene.bodies.push_back(body);
  }
  built.model = assemble(built.scene);
  built.h = build_hierarchy(built.scene, built.model);
  return built;
}
/// Two particles that are too far from each other for a bond, and one alone.
Built without_bonds(std::size_t count) {
  Built built;
  built.scene.materials = {material("corotated", 1e5, 0.3)};
  Model& model = built.model;
  model.spacing = spacing;
  for (std::size_t i = 0; i < count; ++i) model.position.push_back(Vector3(0.7 * double(i), 0, 0));
  model.reference = model.position;
  model.volume.assign(count, 1e-3);
  model.mass.assign(count, 1);
  model.body.assign(count, 0);
  model.material.assign(count, 0);
  model.bodies.resize(1);
  model.bodies[0].count = static_cast<std::uint32_t>(count);
  built.h = build_hierarchy(built.scene, model);
  return built;
}

std::vector<std::pair<std::string, Built>> all() {
  std::vector<std::pair<std::string, Built>> found;
  found.emplace_back("block", build(block(7, 5, 4, spacing)));
  found.emplace_back("long rod", build(block(33, 2, 2, spacing)));
  found.emplace_back("string of particles", build(block(12, 1, 1, spacing)));
  found.emplace_back("L", build(l_shape()));
  found.emplace_back("irregular", build(irregular()));
  found.emplace_back("two bodies", two_bodies());
  found.emplace_back("one particle", without_bonds(1));
  found.emplace_back("two without a bond", without_bonds(2));
  return found;
}

std::uint32_t neighbour(const Hierarchy& h, std::uint32_t n, std::uint32_t slot) {
  return h.neighbour[(n / 16 * 27 + slot) * 16 + n % 16];
}
std::uint32_t cell(const Hierarchy& h, std::uint32_t n, std::uint32_t c) {
  return h.cell[(n / 16 * 8 + c) * 16 + n % 16];
}

/// Interpolation of each particle, or of each node of `level`: to node, by weight; entries without weight
/// left out.
using Rows = std::vector<std::map<std::uint32_t, double>>;
Rows interpolation(const std::vector<std::uint32_t>& node, const std::vector<double>& weight,
                   std::size_t first, std::size_t count) {
  Rows rows(count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t a = 0; a < 8; ++a) {
      const std::size_t at = ((first + i) / 16 * 8 + a) * 16 + (first + i) % 16;
      if (weight[at] != 0) rows[i][node[at]] += weight[at];
    }
  return rows;
}
Rows restriction(const Hierarchy& h, const HierarchyLevel& level) {
  Rows rows(level.nodes);
  for (std::uint32_t n = 0; n < level.nodes; ++n)
    for (std::uint32_t row = h.gather_begin[level.first_gather + n / 16];
         row < h.gather_begin[level.first_gather + n / 16 + 1]; ++row)
      if (h.gather_weight[16 * row + n % 16] != 0)
        rows[n][h.gather[16 * row + n % 16]] += h.gather_weight[16 * row + n % 16];
  return rows;
}

/// Where the nodes of a level are, in its cells, from who neighbours whom; each connected part from its own
/// zero.
struct Places {
  std::vector<Vector3> at;
  std::vector<int> part;
};
Places places(const Hierarchy& h, const HierarchyLevel& level) {
  Places p{std::vector<Vector3>(level.nodes, Vector3::Zero()), std::vector<int>(level.nodes, -1)};
  int parts = 0;
  for (std::uint32_t seed = 0; seed < level.nodes; ++seed) {
    if (p.part[seed] >= 0) continue;
    std::queue<std::uint32_t> todo({seed});
    p.part[seed] = parts;
    while (!todo.empty()) {
      const std::uint32_t n = todo.front();
      todo.pop();
      for (std::uint32_t k = 0; k < 27; ++k) {
        const std::uint32_t other = neighbour(h, level.first_node + n, k) - level.first_node;
        const Vector3 at = p.at[n] + Vector3(double(k % 3) - 1, double(k / 3 % 3) - 1, double(k / 9) - 1);
        if (other == n) continue;
        if (p.part[other] >= 0) {
          EXPECT_EQ(p.at[other], at) << "two ways to a node disagree";
          continue;
        }
        p.part[other] = parts, p.at[other] = at;
        todo.push(other);
      }
    }
    ++parts;
  }
  return p;
}

TEST(Hierarchy, LevelsFollowEachOther) {
  for (const auto& [name, built] : all()) {
    SCOPED_TRACE(name);
    const Hierarchy& h = built.h;
    ASSERT_FALSE(h.levels.empty());
    std::uint32_t node = 0, cells = 0;
    for (const HierarchyLevel& level : h.levels) {
      EXPECT_EQ(level.first_node, node);
      EXPECT_EQ(level.first_cell, cells);
      EXPECT_EQ(level.first_node % 16, 0u);
      node += (level.nodes + 15) / 16 * 16;
      cells += level.cells;
    }
    EXPECT_EQ(h.nodes, node);
    EXPECT_EQ(h.cells, cells);
    EXPECT_EQ(h.signature.size(), cells);
    EXPECT_EQ(h.stiffness.size(), std::size_t{Hierarchy::table_size} * h.signatures);
    EXPECT_EQ(h.neighbour.size(), std::size_t{27} * node);
    EXPECT_EQ(h.cell.size(), std::size_t{8} * node);
    EXPECT_EQ(h.node_parent.size(), std::size_t{8} * node);
    // The last level: one cell a body, its eight nodes in order.
    const HierarchyLevel& last = h.levels.back();
    EXPECT_EQ(h.blocks, built.model.bodies.size());
    EXPECT_EQ(last.cells, h.blocks);
    ASSERT_EQ(last.nodes, 8 * h.blocks);
    for (std::uint32_t n = 0; n < last.nodes; ++n) {
      std::set<std::uint32_t> seen;
      for (std::uint32_t k = 0; k < 27; ++k)
        seen.insert(neighbour(h, last.first_node + n, k) - last.first_node);
      EXPECT_EQ(seen.size(), 8u);
      EXPECT_EQ(*seen.begin(), n / 8 * 8);
      EXPECT_EQ(*seen.rbegin(), n / 8 * 8 + 7);
    }
    // Coarser by level, and no finer one was one cell a body already.
    for (std::size_t l = 1; l < h.levels.size(); ++l) {
      EXPECT_LE(h.levels[l].cells, h.levels[l - 1].cells);
      EXPECT_GT(h.levels[l - 1].cells, h.blocks);
    }
  }
}

TEST(Hierarchy, CellsPartTheParticles) {
  for (const auto& [name, built] : all()) {
    SCOPED_TRACE(name);
    const Hierarchy& h = built.h;
    ASSERT_EQ(h.child_begin.size(), h.cells + 1u);
    for (std::size_t l = 0; l < h.levels.size(); ++l) {
      const HierarchyLevel& level = h.levels[l];
      const std::uint32_t first = l ? h.levels[l - 1].first_cell : 0;
      std::vector<int> held(l ? h.levels[l - 1].cells : built.model.count(), 0);
      for (std::uint32_t c = level.first_cell; c < level.first_cell + level.cells; ++c) {
        EXPECT_LT(h.child_begin[c], h.child_begin[c + 1]) << "an empty cell";
        for (std::uint32_t at = h.child_begin[c]; at < h.child_begin[c + 1]; ++at)
          held.at(h.child[at] - first) += 1;
      }
      EXPECT_EQ(held, std::vector<int>(held.size(), 1)) << "each child has one cell, level " << l;
    }
  }
}

TEST(Hierarchy, NodesAndCellsKnowEachOther) {
  for (const auto& [name, built] : all()) {
    SCOPED_TRACE(name);
    const Hierarchy& h = built.h;
    for (const HierarchyLevel& level : h.levels) {
      std::vector<std::set<std::uint32_t>> corner(level.cells);
      const std::uint32_t padded = (level.nodes + 15) / 16 * 16;
      for (std::uint32_t n = level.first_node; n < level.first_node + padded; ++n) {
        const bool real = n < level.first_node + level.nodes;
        int cells = 0;
        for (std::uint32_t c = 0; c < 8; ++c) {
          const std::uint32_t at = cell(h, n, c);
          if (at == none) continue;
          ++cells;
          ASSERT_GE(at, level.first_cell);
          ASSERT_LT(at, level.first_cell + level.cells);
          EXPECT_TRUE(corner[at - level.first_cell].insert(7 - c).second) << "two nodes are one corner";
          // Corner 7 - c of the cell: its other corners are neighbours.
          for (std::uint32_t b = 0; b < 8; ++b) {
            const std::uint32_t slot =
                (c & 1) + (b & 1) + 3 * ((c >> 1 & 1) + (b >> 1 & 1)) + 9 * ((c >> 2) + (b >> 2));
            const std::uint32_t other = neighbour(h, n, slot);
            EXPECT_EQ(other == n, slot == 13);
            EXPECT_EQ(neighbour(h, other, 26 - slot), n);
            EXPECT_EQ(cell(h, other, 7 - b), at);
          }
        }
        EXPECT_EQ(cells > 0, real) << "node " << n;
        for (std::uint32_t k = 0; k < 27 && !real; ++k) EXPECT_EQ(neighbour(h, n, k), n);
      }
      for (const auto& corners : corner) EXPECT_EQ(corners.size(), 8u);
    }
  }
}

TEST(Hierarchy, RestrictionIsTheTransposeOfInterpolation) {
  for (const auto& [name, built] : all()) {
    SCOPED_TRACE(name);
    const Hierarchy& h = built.h;
    for (std::size_t l = 0; l < h.levels.size(); ++l) {
      const std::uint32_t finer = l ? h.levels[l - 1].first_node : 0;
      const Rows up = l ? interpolation(h.node_parent, h.parent_weight, finer, h.levels[l - 1].nodes)
                        : interpolation(h.particle_node, h.particle_weight, 0, built.model.count());
      const Rows down = restriction(h, h.levels[l]);
      std::size_t entries = 0;
      for (std::uint32_t i = 0; i < up.size(); ++i) {
        double sum = 0;
        for (const auto& [node, weight] : up[i]) {
          sum += weight;
          const auto& row = down.at(node - h.levels[l].first_node);
          ASSERT_TRUE(row.count(finer + i)) << "entity " << i << ", level " << l;
          EXPECT_EQ(row.at(finer + i), weight);
          EXPECT_GT(weight, 0);
        }
        EXPECT_NEAR(sum, 1, 1e-15) << "weights of entity " << i << ", level " << l;
        entries += up[i].size();
      }
      std::size_t gathered = 0;
      for (const auto& row : down) gathered += row.size();
      EXPECT_EQ(gathered, entries) << "level " << l;
    }
  }
}

// With nodes at their places a linear field is interpolated exactly.
TEST(Hierarchy, LinearFieldsAreInterpolatedExactly) {
  for (const auto& [name, built] : all()) {
    if (name == "two without a bond") continue; // their cells do not touch on all levels: no common origin
    SCOPED_TRACE(name);
    const Hierarchy& h = built.h;
    double width = 2 * spacing;
    Places finer;
    for (std::size_t l = 0; l < h.levels.size(); ++l, width *= 2) {
      const Places coarse = places(h, h.levels[l]);
      std::map<int, Vector3> origin; // of each part: from the first that it interpolates
      const Rows rows =
          l ? interpolation(h.node_parent, h.parent_weight, h.levels[l - 1].first_node, h.levels[l - 1].nodes)
            : interpolation(h.particle_node, h.particle_weight, 0, built.model.count());
      for (std::size_t i = 0; i < rows.size(); ++i) {
        Vector3 found = Vector3::Zero();
        int part = -1;
        for (const auto& [node, weight] : rows[i]) {
          found += weight * width * coarse.at[node - h.levels[l].first_node];
          part = coarse.part[node - h.levels[l].first_node];
        }
        const Vector3 place = l ? Vector3(width / 2 * finer.at[i]) : built.model.reference[i];
        const Vector3 shift = place - found;
        const auto [at, fresh] = origin.try_emplace(part, shift);
        EXPECT_LT((shift - at->second).norm(), 1e-13) << "entity " << i << ", level " << l;
      }
      EXPECT_EQ(origin.size(), built.model.bodies.size());
      finer = coarse;
    }
  }
}

// Energy of a linear field, of a rigid turn, and mass, from the tables alone.
TEST(Hierarchy, TablesHoldTheMatter) {
  for (const auto& [name, built] : all()) {
    SCOPED_TRACE(name);
    const Hierarchy& h = built.h;
    const Material& m = built.scene.materials[0];
    const double mu = m.young / (2 * (1 + m.poisson)), lambda = mu * 2 * m.poisson / (1 - 2 * m.poisson);
    const Matrix3 a = (Matrix3() << 0.3, -0.2, 0.5, 0.1, 0.7, -0.4, 0.2, 0.6, -0.1).finished();
    double width = 2 * spacing;
    for (const HierarchyLevel& level : h.levels) {
      double mass = 0, energy = 0, turned = 0;
      for (std::uint32_t c = level.first_cell; c < level.first_cell + level.cells; ++c) {
        const double* table = &h.stiffness[std::size_t{Hierarchy::table_size} * h.signature[c]];
        for (int p = 0; p < 8; ++p) {
          Matrix3 row_sum = Matrix3::Zero();
          for (int q = 0; q < 8; ++q) {
            const double* e = table + 12 * (8 * p + q);
            const Matrix3 k = (Matrix3() << e[0], e[1], e[2], e[3], e[4], e[5], e[6], e[7], e[8]).finished();
            const double* back = table + 12 * (8 * q + p);
            const Matrix3 other =
                (Matrix3() << back[0], back[1], back[2], back[3], back[4], back[5], back[6], back[7], back[8])
                    .finished();
            EXPECT_LT((k - other.transpose()).norm(), 1e-10 * mu * spacing);
            EXPECT_NEAR(e[9], back[9], 1e-15 * e[9]);
            row_sum += k;
            mass += e[9];
            EXPECT_NEAR(e[10], lambda / mu, 1e-12);
            EXPECT_EQ(e[11], 0);
            const auto corner = [width](int n) -> Vector3 {
              return Vector3(n & 1, n >> 1 & 1, n >> 2) * width;
            };
            // u_p . K_pq u_q with K = mu (tr M 1 + M^T) + lambda M
            const Matrix3 block = k.trace() * Matrix3::Identity() + k.transpose() + e[10] * k;
            energy += (a * corner(p)).dot(block * (a * corner(q))) / 2;
            const Matrix3 skew = a - a.transpose();
            turned += (skew * corner(p)).dot(block * (skew * corner(q))) / 2;
          }
          EXPECT_LT(row_sum.norm(), 1e-10 * mu * spacing) << "a shift costs nothing";
        }
      }
      double matter = 0, volume = 0;
      for (std::size_t i = 0; i < built.model.mass.size(); ++i)
        matter += built.model.mass[i], volume += built.model.volume[i];
      EXPECT_NEAR(mass, matter, 1e-12 * matter);
      const Matrix3 strain = (a + a.transpose()) / 2;
      const double wanted =
          volume * (mu * strain.squaredNorm() + lambda / 2 * strain.trace() * strain.trace());
      EXPECT_NEAR(energy, wanted, 1e-12 * wanted);
      EXPECT_NEAR(turned, 0, 1e-12 * wanted);
      width *= 2;
    }
  }
}

TEST(Hierarchy, EqualCellsShareATable) {
  const Built regular = build(block(16, 16, 16, spacing));
  EXPECT_EQ(regular.h.levels.size(), 4u);
  EXPECT_EQ(regular.h.levels[0].cells, 512u);
  EXPECT_EQ(regular.h.levels[0].nodes, 729u);
  EXPECT_EQ(regular.h.signatures, 4u) << "all cells of a level are full";
  const Built odd = build(irregular());
  EXPECT_EQ(odd.h.signatures, odd.h.cells);
}

TEST(Hierarchy, TwoMaterialsInABody) {
  Built built = build(block(4, 4, 4, spacing));
  built.scene.materials.push_back(material("corotated", 1e7, 0.45));
  for (std::uint32_t i = 0; i < built.model.count(); ++i)
    built.model.material[i] = built.model.reference[i].x() > built.model.reference[0].x() + 0.15 ? 1 : 0;
  const Hierarchy h = build_hierarchy(built.scene, built.model);
  EXPECT_EQ(h.signatures, 3u) << "two kinds of cells of two spacings, and the one that holds them all";
  const auto trace = [&](std::uint32_t c) {
    const double* e = &h.stiffness[std::size_t{Hierarchy::table_size} * h.signature[c]];
    return e[0] + e[4] + e[8];
  };
  const double mu[] = {1e5 / 2.6, 1e7 / 2.9};
  EXPECT_NEAR(trace(1) / trace(0), mu[1] / mu[0], 1e-9 * mu[1] / mu[0]);
  const double lambda = mu[1] * 0.9 / 0.1 + mu[0] * 0.6 / 0.4;
  EXPECT_NEAR(h.stiffness[std::size_t{Hierarchy::table_size} * h.signature[h.levels[1].first_cell] + 10],
              lambda / (mu[0] + mu[1]), 1e-9);
}

TEST(Hierarchy, NothingOfNoParticles) {
  const Built built = without_bonds(0);
  EXPECT_TRUE(built.h.levels.empty());
  EXPECT_EQ(built.h.nodes, 0u);
}

} // namespace
} // namespace pliant::test
