// Bonds against brute force; slices; order of particles; components.
#include "engine/core/error.h"
#include "engine/model/offset.h"
#include "tests/model/lattice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tuple>

namespace pliant {
namespace {

using test::block;
using test::material;

std::vector<Vector3> random_points(std::size_t count, unsigned seed) {
  std::mt19937 generator(seed);
  std::vector<Vector3> points(count);
  for (Vector3& p : points)
    for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<double>(generator()) / 4294967296.0;
  return points;
}

void expect_brute_force(const std::vector<Vector3>& points, double horizon) {
  const Bonds bonds = find_bonds(points, horizon);
  ASSERT_EQ(bonds.begin.size(), points.size() + 1);
  std::size_t total = 0;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t j = 0; j < points.size(); ++j)
      if (i != j && (points[i] - points[j]).norm() < horizon) expected.push_back(j);
    const std::vector<std::uint32_t> row(bonds.neighbour.begin() + bonds.begin[i],
                                         bonds.neighbour.begin() + bonds.begin[i + 1]);
    ASSERT_EQ(row, expected) << "particle " << i;
    total += expected.size();
    for (std::uint32_t b = bonds.begin[i]; b < bonds.begin[i + 1]; ++b) {
      const std::uint32_t back = bonds.reverse[b], j = bonds.neighbour[b];
      ASSERT_GE(back, bonds.begin[j]);
      ASSERT_LT(back, bonds.begin[j + 1]);
      ASSERT_EQ(bonds.neighbour[back], i);
      ASSERT_EQ(bonds.reverse[back], b);
    }
  }
  EXPECT_EQ(bonds.count(), total);
}

TEST(Bonds, EqualBruteForceOnRandomPoints) {
  expect_brute_force(random_points(900, 7), 0.11);
  expect_brute_force(random_points(60, 8), 3.0); // all with all
  auto far = random_points(300, 9);
  far.push_back({1e7, -1e7, 3});
  far.push_back({1e7, -1e7, 3.05});
  expect_brute_force(far, 0.2);
}

TEST(Bonds, HorizonIsExclusive) {
  const std::vector<Vector3> points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_EQ(find_bonds(points, 1.0).count(), 0u);
  EXPECT_EQ(find_bonds(points, 1.0000001).count(), 4u);
  EXPECT_EQ(find_bonds(points, 2.0).count(), 4u);
}

TEST(Bonds, HandleNoPointsAndRefuseNonsense) {
  EXPECT_EQ(find_bonds({}, 1).begin, std::vector<std::uint32_t>{0});
  EXPECT_EQ(find_bonds({{1, 2, 3}}, 1).count(), 0u);
  EXPECT_THROW(find_bonds({{1, 2, 3}}, 0), Error);
  EXPECT_THROW(find_bonds({{1, NAN, 3}}, 1), Error);
}

TEST(Bonds, LatticeShellsHaveTheirNumbers) {
  const auto neighbours = [](double horizon) {
    const Bonds bonds = find_bonds(block(9, 9, 9, 1), horizon);
    const std::size_t centre = 4 + 9 * (4 + 9 * 4);
    return bonds.begin[centre + 1] - bonds.begin[centre];
  };
  EXPECT_EQ(neighbours(1.87), 26u);
  EXPECT_EQ(neighbours(2.1), 32u);
  EXPECT_EQ(neighbours(2.35), 56u);
  EXPECT_EQ(neighbours(2.6), 80u);
  EXPECT_EQ(neighbours(3.1), 122u);
}

TEST(Offset, PacksAndUnpacksEveryField) {
  for (const GridVector v :
       {GridVector{0, 0, 0}, {511, -511, 1}, {-1, -1, -1}, {-120, 240, -360}, {3, -512, 511}}) {
    EXPECT_EQ(unpack_offset(pack_offset(v)), v);
    EXPECT_EQ(pack_offset(v) >> 30, 0u);
  }
  EXPECT_EQ(pack_offset({1, 2, 3}), 1u | 2u << 10 | 3u << 20);
}

TEST(Slices, HoldEveryBondOnceAndPadWithNothing) {
  auto points = block(5, 4, 3, 0.1);
  std::mt19937 generator(3);
  for (Vector3& p : points) // off the lattice, so that vectors and snapping are put to the test
    for (int axis = 0; axis < 3; ++axis)
      p[axis] += 0.02 * (static_cast<double>(generator()) / 4294967296.0 - 0.5);
  const Model model = assemble_points(points, 0.1, 1.87, material("ordinary", 1e5, 0.3), 1e-3);
  const SlicedBonds sliced = slice_bonds(model);
  ASSERT_EQ(sliced.slice_begin.size(), (points.size() + 15) / 16 + 1);
  ASSERT_EQ(sliced.slice_begin.back(), sliced.neighbour.size());
  const std::vector<double> stiffness = diagonal_stiffness(model);
  std::multiset<std::pair<std::uint32_t, std::uint32_t>> found;
  std::vector<double> summed(model.count(), 0);
  for (std::size_t s = 0; s + 1 < sliced.slice_begin.size(); ++s) {
    EXPECT_EQ(sliced.slice_begin[s] % slice_width, 0u);
    for (std::uint32_t at = sliced.slice_begin[s]; at < sliced.slice_begin[s + 1]; ++at) {
      const auto i = static_cast<std::uint32_t>(s * slice_width + (at - sliced.slice_begin[s]) % slice_width);
      const std::uint32_t j = sliced.neighbour[at];
      ASSERT_LT(j, model.count());
      if (sliced.offset[at] == 0) {
        EXPECT_EQ(sliced.weight_out[at], 0);
        EXPECT_EQ(sliced.weight_in[at], 0);
        EXPECT_EQ(j, std::min<std::size_t>(i, model.count() - 1));
        continue;
      }
      found.insert({i, j});
      const Vector3 vector = from_grid(unpack_offset(sliced.offset[at]), model.spacing);
      EXPECT_LT((vector - (model.reference[j] - model.reference[i])).norm(), 1e-15);
      const double squared = vector.squaredNorm();
      const auto row = model.bonds.neighbour.begin();
      const auto bond = std::lower_bound(row + model.bonds.begin[i], row + model.bonds.begin[i + 1], j) - row;
      const double out = model.constants[0].modulus * model.volume[i] * model.bonds.weight[bond] / squared;
      const double in = model.constants[0].modulus * model.volume[j] *
                        model.bonds.weight[model.bonds.reverse[bond]] / squared;
      EXPECT_NEAR(sliced.weight_out[at], out, 1e-12 * out);
      EXPECT_NEAR(sliced.weight_in[at], in, 1e-12 * in);
      summed[i] += model.constants[0].bound * (out + in);
    }
  }
  EXPECT_EQ(found.size(), model.bonds.count());
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    EXPECT_NEAR(stiffness[i], summed[i], 1e-12 * summed[i]);
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b)
      EXPECT_EQ(found.count({i, model.bonds.neighbour[b]}), 1u);
  }
}

TEST(AssemblePoints, SortsByComponentThenLexicographically) {
  // Two blocks that interleave along z: lexicographic order alone would mix them.
  auto points = block(3, 3, 3, 0.5);
  for (const Vector3& p : block(2, 2, 2, 0.5)) points.push_back(p + Vector3(10, 0, 0.5));
  std::mt19937 generator(5);
  std::shuffle(points.begin(), points.end(), generator);
  const Model model = assemble_points(points, 0.5, 1.87, material("corotated", 1e5, 0.3), 0.125);
  ASSERT_EQ(model.count(), 35u);
  EXPECT_EQ(model.components, 2u);
  EXPECT_TRUE(std::is_sorted(model.component.begin(), model.component.end()));
  for (std::size_t i = 1; i < model.count(); ++i) {
    if (model.component[i] != model.component[i - 1]) continue;
    const Vector3 &p = model.reference[i - 1], &q = model.reference[i];
    EXPECT_LT(std::make_tuple(p.z(), p.y(), p.x()), std::make_tuple(q.z(), q.y(), q.x()));
  }
  std::set<std::uint32_t> ids;
  for (std::size_t i = 0; i < model.count(); ++i) {
    ids.insert(model.id[i]);
    EXPECT_LT((model.position[i] - points[model.id[i]]).norm(), 1e-12);
  }
  EXPECT_EQ(ids.size(), 35u);
  for (std::size_t b = 0; b < model.bonds.count(); ++b)
    EXPECT_EQ(model.component[model.bonds.neighbour[b]],
              model.component[model.bonds.neighbour[model.bonds.reverse[b]]]);
}

TEST(AssemblePoints, SmallAndLonelyBodiesAreLegal) {
  const Material rubber = material("corotated", 1e5, 0.3);
  const Model none = assemble_points({}, 0.1, 1.87, rubber, 1e-3);
  EXPECT_EQ(none.count(), 0u);
  EXPECT_EQ(slice_bonds(none).slice_begin, std::vector<std::uint32_t>{0});
  const Model one = assemble_points({{5, 6, 7}}, 0.1, 1.87, rubber, 1e-3);
  EXPECT_EQ(one.bonds.count(), 0u);
  EXPECT_EQ(diagonal_stiffness(one), std::vector<double>{0});
  const Model pair = assemble_points({{0, 0, 0}, {0.1, 0, 0}}, 0.1, 1.87, rubber, 1e-3);
  EXPECT_THAT(pair.bonds.weight, testing::ElementsAre(1, 1));
  EXPECT_EQ(pair.weight_report.share_over_5_percent, 1);
}

TEST(AssemblePoints, RefusesWhatCannotBe) {
  const Material rubber = material("corotated", 1e5, 0.3);
  const auto message = [](const auto& work) -> std::string {
    try {
      work();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      return error.what();
    }
    return "nothing thrown";
  };
  EXPECT_THAT(message([&] {
                assemble_points({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}, 1, 1.87, rubber, 1);
              }),
              testing::HasSubstr("particles 0 and 2 coincide"));
  EXPECT_THAT(message([&] {
                assemble_points({{0, 0, 0}, {NAN, 0, 0}}, 1, 1.87, rubber, 1);
              }),
              testing::HasSubstr("particle 1 is not finite"));
  EXPECT_THAT(message([&] {
                assemble_points({{0, 0, 0}}, 1, 4.5, rubber, 1);
              }),
              testing::HasSubstr("horizon"));
  EXPECT_THAT(message([&] {
                assemble_points({{0, 0, 0}}, 1, 1.87, material("rubbery", 1, 0), 1);
              }),
              testing::HasSubstr("corotated, ordinary, projective"));
  EXPECT_THAT(message([&] {
                assemble_points({{0, 0, 0}}, 1, 1.87, material("ordinary", 1, 0.5), 1);
              }),
              testing::HasSubstr("0.499"));
  EXPECT_THAT(message([&] {
                assemble_points({{0, 0, 0}}, 1, 1.87, material("projective", 1, 0.3), 1);
              }),
              testing::HasSubstr("0.25"));
}

} // namespace
} // namespace pliant
