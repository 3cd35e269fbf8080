// Moments of the weights; constants of the laws; the discrete energy of a homogeneous strain.
#include "tests/model/lattice.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pliant {
namespace {

using test::block;
using test::material;
using test::moment;
using test::second_moment;

struct BulkMoments {
  double m1111 = 0, m1122 = 0;
};

/// From the shells of the cubic lattice, each (a, b, c) with its permutations and signs.
BulkMoments shell_moments(double horizon, double exponent) {
  double sum = 0, fourth = 0, mixed = 0;
  for (int a = -4; a <= 4; ++a)
    for (int b = -4; b <= 4; ++b)
      for (int c = -4; c <= 4; ++c) {
        const double squared = a * a + b * b + c * c;
        if (squared == 0 || squared >= horizon * horizon) continue;
        const double w = std::pow(squared, exponent / 2);
        sum += w;
        fourth += w * a * a * a * a / (squared * squared);
        mixed += w * a * a * b * b / (squared * squared);
      }
  return {fourth / sum, mixed / sum};
}

TEST(Weights, NormalisedMomentsOfTheBulkLattice) {
  struct Row {
    double horizon, exponent, m1111, m1122;
  };
  for (const Row& row : {Row{1.87, 0, .1880, .0726},
                         {1.87, -0.7, .2001, .0666},
                         {2.1, 0, .2153, .0590},
                         {2.6, 1, .2005, .0664},
                         {3.1, -1, .2014, .0660}}) {
    const BulkMoments shells = shell_moments(row.horizon, row.exponent);
    EXPECT_NEAR(shells.m1111, row.m1111, 6e-5);
    EXPECT_NEAR(shells.m1122, row.m1122, 6e-5);
    const Model model = assemble_points(block(7, 7, 7, 0.3), 0.3, row.horizon, material("ordinary", 1, 0.25),
                                        0.027, "normalised", row.exponent);
    const std::uint32_t centre = 3 + 7 * (3 + 7 * 3);
    EXPECT_NEAR(moment(model, centre, 4, 0, 0), shells.m1111, 1e-14);
    EXPECT_NEAR(moment(model, centre, 0, 2, 2), shells.m1122, 1e-14);
  }
}

void expect_proper(const Model& model) {
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    double sum = 0;
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      EXPECT_GE(model.bonds.weight[b], 0);
      sum += model.bonds.weight[b];
    }
    EXPECT_NEAR(sum, 1, 1e-14) << "particle " << i;
  }
}

TEST(Weights, SecondMomentsAreExactEverywhereInABlock) {
  for (const double horizon : {1.87, 2.1, 2.6, 3.1}) {
    const Model model = assemble_points(block(8, 7, 7, 0.02), 0.02, horizon, material("corotated", 1, 0.3),
                                        8e-6); // faces to corners
    expect_proper(model);
    double worst = 0;
    for (std::uint32_t i = 0; i < model.count(); ++i)
      worst = std::max(worst, (second_moment(model, i) - Matrix3::Identity() / 3).cwiseAbs().maxCoeff());
    EXPECT_LT(worst, 1e-14) << "horizon " << horizon;
    EXPECT_LT(model.weight_report.worst_residual, 1e-13);
    EXPECT_EQ(model.weight_report.share_over_5_percent, 0);
  }
}

TEST(Weights, CornerKeepsThreeBondsAndEdgeEight) {
  const Model model = assemble_points(block(6, 6, 6, 1), 1, 1.87, material("corotated", 1, 0.3), 1);
  const auto positive = [&](std::uint32_t i) {
    int count = 0;
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b)
      count += model.bonds.weight[b] > 1e-9;
    return count;
  };
  EXPECT_EQ(model.bonds.begin[1] - model.bonds.begin[0], 7u);
  EXPECT_EQ(positive(0), 3);
  EXPECT_EQ(model.bonds.begin[4] - model.bonds.begin[3], 11u);
  EXPECT_EQ(positive(3), 8);
}

TEST(Weights, FewSignaturesInABlock) {
  for (const char* law : {"corotated", "ordinary"}) {
    const Material stuff = material(law, 1, 0.25);
    // One for each of corner, edge, face and bulk in each orientation: 3 * 3 * 3.
    EXPECT_EQ(assemble_points(block(6, 7, 8, 0.1), 0.1, 1.87, stuff, 1e-3).weight_report.signatures, 27u);
    EXPECT_EQ(assemble_points(block(6, 7, 8, 0.1), 0.1, 2.6, stuff, 1e-3).weight_report.signatures, 125u);
  }
}

TEST(Weights, FourthMomentsInBulkAndOnAFlatFace) {
  for (const double horizon : {1.87, 2.6}) {
    const Model model = assemble_points(block(9, 9, 9, 1), 1, horizon, material("ordinary", 1, 0.3), 1);
    expect_proper(model);
    for (const std::uint32_t i : {4u + 9 * (4 + 9 * 4), 4u + 9 * 4, 9u * (4 + 9 * 4)}) {
      EXPECT_NEAR(moment(model, i, 4, 0, 0), 0.2, 1e-13);
      EXPECT_NEAR(moment(model, i, 0, 4, 0), 0.2, 1e-13);
      EXPECT_NEAR(moment(model, i, 0, 0, 4), 0.2, 1e-13);
      EXPECT_NEAR(moment(model, i, 2, 2, 0), 1. / 15, 1e-13);
      EXPECT_NEAR(moment(model, i, 0, 2, 2), 1. / 15, 1e-13);
      EXPECT_NEAR(moment(model, i, 2, 0, 2), 1. / 15, 1e-13);
      EXPECT_NEAR(moment(model, i, 3, 1, 0), 0, 1e-13);
      EXPECT_NEAR(moment(model, i, 2, 1, 1), 0, 1e-13);
    }
    // A corner cannot have them; the miss is known and reported, relative to the target's norm, sqrt(1/5).
    EXPECT_GT(model.weight_report.worst_residual, 0.05);
    EXPECT_LT(model.weight_report.worst_residual, 0.25 / std::sqrt(0.2));
    EXPECT_GT(model.weight_report.share_over_5_percent, 0);
  }
}

TEST(Weights, DegenerateNeighbourhoodsGetTheLeastMiss) {
  // A row: the ends see one neighbour, the middle two; all that can be done is to share the weight.
  const Model row = assemble_points(block(3, 1, 1, 1), 1, 1.87, material("corotated", 1, 0.3), 1);
  EXPECT_EQ(row.weight_report.share_over_5_percent, 1);
  EXPECT_NEAR(row.weight_report.worst_residual, std::sqrt(2.0), 1e-12); // |xx - I/3| / |I/3|
  expect_proper(row);
  EXPECT_NEAR(row.bonds.weight[1], 0.5, 1e-12);
  // A sheet: isotropic in its plane is the best it can be; the slack of the least squares bounds the
  // accuracy.
  const Model sheet = assemble_points(block(5, 5, 1, 1), 1, 1.87, material("corotated", 1, 0.3), 1);
  expect_proper(sheet);
  const Matrix3 centre = second_moment(sheet, 12);
  EXPECT_NEAR(centre(0, 0), 0.5, 1e-8);
  EXPECT_NEAR(centre(1, 1), 0.5, 1e-8);
  EXPECT_NEAR(centre(0, 1), 0, 1e-8);
}

TEST(LawConstants, AreTheAveragesOfTheClassicalOnes) {
  const double young = 7e5, poisson = 0.4, shear = young / 2.8, lame = young * 0.4 / (1.4 * 0.2);
  const LawConstants corotated = law_constants(Law::corotated, young, poisson, 0.5);
  EXPECT_NEAR(corotated.modulus, 6 * shear, 1e-6);
  EXPECT_NEAR(corotated.coupling, 1.5 * lame / shear, 1e-12);
  EXPECT_NEAR(corotated.bound, 1 + corotated.coupling, 1e-12);
  const LawConstants ordinary = law_constants(Law::ordinary, young, poisson, 0.5);
  const double a = 3 * young / (2 * 0.2), b = 15 * young / (4 * 1.4);
  EXPECT_NEAR(ordinary.modulus, 2 * b, 1e-6);
  EXPECT_NEAR(ordinary.coupling, (a - b) / b, 1e-12);
  EXPECT_NEAR(ordinary.bound, a / b, 1e-12);
  const LawConstants soft =
      law_constants(Law::ordinary, young, 0.1, 0.5); // a < b: the bound is the bond's own
  EXPECT_LT(soft.coupling, 0);
  EXPECT_EQ(soft.bound, 1);
  EXPECT_NEAR(law_constants(Law::ordinary, young, 0.25, 0.5).coupling, 0, 1e-14);
  const LawConstants projective = law_constants(Law::projective, young, 0.25, 0.3);
  EXPECT_NEAR(projective.modulus, 6 * young, 1e-6);
  EXPECT_EQ(projective.coupling, 0.3);
  EXPECT_EQ(projective.bound, 1);
}

/// Energy density of a particle from the slices' stiffness, under y = F x.
double energy_density(const Model& model, std::uint32_t i, const Matrix3& strain, Law law) {
  const LawConstants& c = model.constants[0];
  const Matrix3 deformation = Matrix3::Identity() + strain; // symmetric: its rotation is the identity
  double sum = 0, mean = 0;
  for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
    const Vector3 n = test::direction(model, i, b), y = deformation * n;
    const double w = model.bonds.weight[b];
    if (law == Law::corotated) {
      sum += w * (y - n).squaredNorm();
      mean += w * n.dot(y);
    } else {
      sum += w * (y.norm() - 1) * (y.norm() - 1);
      mean += w * y.norm();
    }
  }
  return c.modulus / 2 * (sum + c.coupling * (mean - 1) * (mean - 1));
}

TEST(Energy, OfASmallStrainIsTheClassicalOne) {
  Matrix3 strain;
  strain << 1.0, 0.4, -0.2, 0.4, -0.7, 0.3, -0.2, 0.3, 0.5;
  for (const double poisson : {0.0, 0.25, 0.45}) {
    const double young = 3e4, shear = young / (2 * (1 + poisson));
    const double lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
    for (const Law law : {Law::corotated, Law::ordinary}) {
      const Model model =
          assemble_points(block(5, 5, 5, 0.01), 0.01, 1.87, material(law_name(law), young, poisson), 1e-6);
      const std::uint32_t bulk = 62, face = 12;
      const Matrix3 small = 1e-7 * strain;
      const double trace = small.trace(), classical = shear * small.squaredNorm() + lame / 2 * trace * trace;
      for (const std::uint32_t i : {bulk, face})
        EXPECT_NEAR(energy_density(model, i, small, law) / classical, 1, 1e-6)
            << law_name(law) << " " << poisson;
    }
  }
}

} // namespace
} // namespace pliant
