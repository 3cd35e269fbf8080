// surface_tear: the pieces in which the particles of a triangle hang together by whole bonds, against a plain
// search.
#include "kernels/surface_tear.h"
#include "tests/support/kernel_bonds.h"

#include <set>

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(SurfaceTear);

struct Problem {
  static constexpr std::uint32_t first_triangle = 5;
  static constexpr std::size_t guard = 3; ///< triangles behind
  Values in;
  Expected torn;
  std::size_t count, torn_count = 0;

  /// `vertices` follow particles of a body of 129, a share of whose bonds is broken.
  Problem(std::size_t triangles, double share, unsigned seed) : count(triangles) {
    const BondProblem p("ordinary", 129, kernel_seed + 71);
    Random random(seed);
    for (const char* name : {"first", "first_slice", "slice_begin", "bond"})
      in[name] = p.bond_values.at(name);
    std::vector<std::set<std::size_t>> whole(p.count);
    for (std::size_t i = 0; i < p.count; ++i)
      for (const auto& bond : p.bonds[i])
        if (bond.to > i && random(0.5) + 0.5 >= share) whole[i].insert(bond.to), whole[bond.to].insert(i);
    for (std::size_t i = 0; i < p.count; ++i)
      for (std::size_t r = 0; r < p.bonds[i].size(); ++r) {
        const auto row = static_cast<std::size_t>(in["slice_begin"][p.first_slice + i / 16]) + r;
        if (!whole[i].count(p.bonds[i][r].to)) in["bond"][32 * row + i % 16] = double(p.first + i);
      }
    in["first_triangle"] = {double(first_triangle)};
    const auto pick = [&](std::size_t below) {
      return std::min(below - 1, static_cast<std::size_t>((random(0.5) + 0.5) * double(below)));
    };
    std::vector<std::array<std::size_t, 4>> followed;
    for (std::size_t v = 0; v < 200; ++v) { // a particle and three of its neighbours; some twice
      const std::size_t i = pick(p.count);
      std::array<std::size_t, 4> four{i, i, i, i};
      for (std::size_t k = 1; k < 4 && !p.bonds[i].empty(); ++k)
        four[k] = p.bonds[i][pick(p.bonds[i].size())].to;
      followed.push_back(four);
      for (const std::size_t one : four) in["skin_particle"].push_back(double(p.first + one));
    }
    const std::size_t total = first_triangle + triangles + guard;
    in["torn"] = std::vector<double>(total, 77);
    torn = Expected(in["torn"]);
    for (std::size_t t = 0; t < total; ++t) {
      std::set<std::size_t> left;
      for (std::size_t k = 0; k < 3; ++k) {
        // Often one vertex thrice: the particles then are neighbours of one.
        const std::size_t v =
            k > 0 && t % 3 != 0 ? static_cast<std::size_t>(in["skin_triangle"][4 * t]) : pick(200);
        in["skin_triangle"].push_back(double(v));
        left.insert(followed[v].begin(), followed[v].end());
      }
      const std::size_t at_rest = 1 + t % 2;
      in["skin_triangle"].push_back(double(at_rest));
      std::size_t pieces = 0;
      for (; !left.empty(); ++pieces) {
        std::vector<std::size_t> piece{*left.begin()};
        left.erase(left.begin());
        for (std::size_t k = 0; k < piece.size(); ++k)
          for (const std::size_t j : whole[piece[k]])
            if (left.erase(j) > 0) piece.push_back(j);
      }
      if (t < first_triangle || t >= first_triangle + triangles) continue;
      torn.set(t, pieces > at_rest ? 1 : 0);
      torn_count += pieces > at_rest;
    }
  }
};

TEST_P(SurfaceTear, PiecesOfEachTriangle) {
  for (const std::size_t size : awkward_sizes)
    for (const double share : {0.0, 0.3, 0.8, 1.1}) {
      const Problem problem(size, share, kernel_seed + 72);
      if (size == 1000) {
        EXPECT_GT(problem.torn_count, 10u);
        EXPECT_LT(problem.torn_count, 999u);
      }
      expect_kernel<kernels::surface_tear::Args>(GetParam(), static_cast<std::uint32_t>(size), problem.in,
                                                 {{"torn", problem.torn}}, 0);
    }
}

} // namespace
} // namespace pliant::test
