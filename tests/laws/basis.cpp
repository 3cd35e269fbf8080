// The basis functions: the paper's formulas, derivatives against differences, limits near and far from rest,
// names, sums.
#include "engine/model/basis.h"
#include "engine/core/error.h"
#include "engine/model/anisotropy.h"
#include "engine/model/stretch_energy.h"
#include "tests/laws/materials.h"

namespace pliant::test {
namespace {

using Kind = BasisTerm::Kind;

std::vector<BasisSum> all_terms() {
  std::vector<BasisSum> sums{{{{Kind::log2, 1, 1.0}}}, saint_venant_kirchhoff_basis()};
  for (int n = 1; n <= largest_power; ++n)
    for (const Kind kind : {Kind::A, Kind::B}) sums.push_back({{{kind, n, 1.0}}});
  return sums;
}

std::string name_of(const BasisSum& sum) {
  return sum.terms.size() == 1 ? basis_name(sum.terms[0]) : "(3 B3 - B1) / 2";
}

/// Eqs. 15 to 17 as printed, in extended precision.
long double printed(const BasisTerm& term, long double s, int derivative) {
  const long double n = term.n, l = std::log(s);
  if (term.kind == Kind::log2)
    return derivative == 0 ? l * l : derivative == 1 ? 2 * l / s : 2 * (1 - l) / (s * s);
  if (term.kind == Kind::A) {
    if (derivative == 1) return (std::pow(s, n) - std::pow(s, -n)) / n;
    if (derivative == 2) return std::pow(s, n - 1) + std::pow(s, -n - 1);
    if (term.n == 1) return (s * s - 1) / 2 - l;
    return ((std::pow(s, n + 1) - 1) / (n + 1) + (std::pow(s, 1 - n) - 1) / (n - 1)) / n;
  }
  if (derivative == 1) return 2 * (std::pow(s, n) - 1) / n;
  if (derivative == 2) return 2 * std::pow(s, n - 1);
  return 2 / n * ((std::pow(s, n + 1) - 1) / (n + 1) - s + 1);
}

TEST(Basis, IsWhatThePaperPrints) {
  double worst = 0;
  for (const BasisSum& sum : all_terms())
    for (const double s : {0.1, 0.13, 0.3, 0.5, 0.75, 0.9, 1.25, 1.7, 2.5, 6.0, 10.0})
      for (int derivative = 0; derivative < 3; ++derivative) {
        long double wanted = 0, size = 0;
        for (const BasisTerm& term : sum.terms) {
          wanted += term.share * printed(term, s, derivative);
          size += std::abs(term.share * printed(term, s, derivative));
        }
        const double got = derivative == 0 ? sum.value(s) : derivative == 1 ? sum.first(s) : sum.second(s);
        worst = std::max(worst, double(std::abs(got - wanted) / size));
      }
  expect_below("values and derivatives against the printed formulas", worst, 1e-14);
}

TEST(Basis, NothingCancelsNearRest) {
  for (const BasisSum& sum : all_terms())
    for (const double e : {1e-12, -1e-12, 1e-8, -1e-8, 1e-5, -1e-5, 1e-3, -1e-3}) {
      // f = e^2 + f'''(1) e^3 / 6 + ..: the leading term, and the next by a difference of f''.
      const double s = 1 + e, third = (sum.second(1 + 1e-4) - sum.second(1 - 1e-4)) / 2e-4, exact = s - 1;
      const double allowed = 40 * exact * exact + 1e-15;
      EXPECT_NEAR(sum.value(s) / (exact * exact), 1 + third * exact / 6, 3 * allowed)
          << name_of(sum) << " " << e;
      EXPECT_NEAR(sum.first(s) / (2 * exact), 1 + third * exact / 4, 5 * allowed) << name_of(sum) << " " << e;
    }
  for (const BasisSum& sum : all_terms()) {
    EXPECT_EQ(sum.value(1), 0);
    EXPECT_EQ(sum.first(1), 0);
    EXPECT_DOUBLE_EQ(sum.second(1), 2) << name_of(sum);
  }
}

TEST(Basis, DerivativesAreThoseOfTheValue) {
  double worst = 0;
  for (const BasisSum& sum : all_terms())
    for (const double s : {0.0, 0.02, 0.05, 0.098, 0.11, 0.2, 0.6, 0.99, 1.01, 1.5, 3.0, 9.9, 10.2, 50.0}) {
      const double d = 1e-4 * std::max(s, 0.02);
      const auto slope = [&](auto f) {
        return (8 * (f(s + d) - f(s - d)) - (f(s + 2 * d) - f(s - 2 * d))) / (12 * d);
      };
      const double first = slope([&](double x) { return sum.value(x); });
      const double second = slope([&](double x) { return sum.first(x); });
      const double scale = std::abs(sum.first(s)) + std::abs(sum.value(s)) / std::max(s, 0.02);
      worst = std::max(worst, std::abs(first - sum.first(s)) / scale);
      worst = std::max(worst, std::abs(second - sum.second(s)) /
                                  (std::abs(sum.second(s)) + std::abs(sum.first(s)) / std::max(s, 0.02)));
    }
  expect_below("derivatives against differences, of the function", worst, 1e-9);
}

// At the ends of the formulas' range neither f nor f' jumps; beyond, f stays convex and finite.
TEST(Basis, GoesOnSmoothlyBeyondTheRange) {
  for (const BasisSum& sum : all_terms())
    for (const double end : {smallest_stretch, largest_stretch}) {
      const double d = 1e-9 * end;
      EXPECT_NEAR(sum.value(end - d) / sum.value(end + d), 1, 1e-6) << name_of(sum);
      EXPECT_NEAR(sum.first(end - d) / sum.first(end + d), 1, 1e-6) << name_of(sum);
    }
  for (int n = 1; n <= largest_power; ++n) {
    const BasisSum a{{{Kind::A, n, 1.0}}};
    EXPECT_TRUE(std::isfinite(a.value(0)));
    EXPECT_GT(a.value(0), a.value(0.1));
    EXPECT_LT(a.value(1e4), 1e30) << "fits single precision";
    for (int step = 0; step < 2000; ++step) EXPECT_GT(a.second(0.01 * step), 0);
  }
}

TEST(Basis, Names) {
  EXPECT_EQ(basis_name(parse_basis("A4")), "A4");
  EXPECT_EQ(parse_basis("B1").kind, Kind::B);
  for (const char* wrong : {"", "A", "A0", "C1", "A1.5", "a1", "B-1", "A01", "A9", "log2", "B 1"})
    EXPECT_THROW(parse_basis(wrong), Error) << wrong;
}

std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  return "";
}

TEST(Basis, SumsAreNormalisedOrRefused) {
  const BasisSum sum = basis_sum({{"A4", 3.0}, {"B1", 1.0}, {"B2", 0.0}});
  EXPECT_DOUBLE_EQ(sum.second(1), 2);
  EXPECT_EQ(sum.terms.size(), 2u);
  EXPECT_NE(refusal([] {
              basis_sum({{"B3", 1.5}, {"B1", -0.5}});
            }).find("above 0.58"),
            std::string::npos)
      << refusal([] {
           basis_sum({{"B3", 1.5}, {"B1", -0.5}});
         });
  EXPECT_NE(refusal([] {
              basis_sum({{"B1", 0.5}, {"A4", -0.8}});
            }).find("not convex at rest"),
            std::string::npos);
  EXPECT_NE(refusal([] { basis_sum({}); }).find("sum to nothing"), std::string::npos);
  EXPECT_NE(refusal([] {
              basis_sum({{"A1", 1}, {"A2", 1}, {"A3", 1}, {"A4", 1}, {"B5", 1}});
            }).find("more than"),
            std::string::npos);
  EXPECT_EQ(refusal([] { basis_sum({{"A1", 1}, {"A2", 1}, {"A3", 1}, {"A4", 1}, {"B4", 1}}); }), "");
}

// Below a ratio of 1/4 lambda_2 is negative: with g = h the energy is convex all the same, with a steeper g
// not.
TEST(Basis, NegativeLambdaNeedsAVolumeTermThatBondsOutweigh) {
  EXPECT_EQ(refusal([] { stretch_energy(basis_of(1e5, 0, {{"A4", 1}}, {{"A4", 1}})); }), "");
  EXPECT_EQ(refusal([] { stretch_energy(basis_of(1e5, 0.3, {{"A8", 1}}, {{"B1", 1}})); }), "");
  const std::string reason = refusal([] { stretch_energy(basis_of(1e5, 0.1, {{"A4", 1}}, {{"B1", 1}})); });
  EXPECT_NE(reason.find("ratios of 0.2"), std::string::npos) << reason;
  Material strong = basis_of(1e5, 0, {{"B1", 1}}, {{"B1", 1}});
  EXPECT_EQ(refusal([&] { stretch_energy(strong); }), "");
  strong.anisotropy = directions_of({20, 0.05, 1});
  EXPECT_NE(refusal([&] { stretch_energy(strong); }).find("not convex"), std::string::npos);
}

// W / mu_2 of neo-Hookean bonds is exact for dilation by theta: mu_L (3/2 (theta^2 - 1) - 3 ln theta) + ..
TEST(Basis, NeoHookeanBondsAreExactForDilation) {
  const double young = 1e5, nu = 0.35, mu = young / (2 * (1 + nu)),
               lame = young * nu / ((1 + nu) * (1 - 2 * nu));
  const StretchEnergy energy = stretch_energy(formed("neo-hookean", "bonds", young, nu));
  for (const double s : {0.6, 0.9, 1.0, 1.1, 1.8}) {
    const double l = 3 * std::log(s), exact = mu / 2 * (3 * s * s - 3) - mu * l + lame / 2 * l * l;
    EXPECT_NEAR(7.5 * mu * (energy.volume.value(s) + energy.bond.value(s)), exact, 1e-10 * young);
  }
}

// --- Directions ------------------------------------------------------------------------------------------

TEST(Strengths, MeansOverTheSphere) {
  EXPECT_NEAR(mean_strength({1, 1, 1}), 1, 1e-12);
  EXPECT_NEAR(mean_softness({3, 3, 3}), 1, 1e-12);
  EXPECT_NEAR(mean_strength({2, 0.5, 1}), 1.26, 0.005);
  EXPECT_NEAR(mean_strength({4, 0.25, 1}), 2.15, 0.005);
  // A spheroid of semi-axes 1, 1 and a: (1 + asinh(q) a^2 / q) / 2 .. with a > 1, q = sqrt(a^2 - 1), of
  // |Sigma N|:
  const double a = 3, q = std::sqrt(a * a - 1), exact = (a + std::asinh(q) / q) / 2;
  for (const Vector3& sigma : {Vector3(1, 1, a), Vector3(a, 1, 1), Vector3(1, a, 1)})
    EXPECT_NEAR(mean_strength(sigma), exact, 1e-12);
  EXPECT_NEAR(mean_strength({1000, 1, 1}), 500 + std::asinh(std::sqrt(1e6 - 1)) / std::sqrt(1e6 - 1) / 2,
              1e-9);
}

TEST(Strengths, BadOnesAreRefused) {
  Anisotropy bad = directions_of({1, 0, 1});
  EXPECT_NE(refusal([&] { check_anisotropy(bad); }).find("above 0"), std::string::npos);
  Matrix3 rows = Matrix3::Identity();
  rows.row(1) = Vector3(0.1, 0.995, 0).normalized();
  bad = directions_of({1, 2, 1}, rows);
  EXPECT_NE(refusal([&] { check_anisotropy(bad); }).find("right angles"), std::string::npos);
  rows = 2 * Matrix3::Identity();
  bad = directions_of({1, 2, 1}, rows);
  EXPECT_NE(refusal([&] { check_anisotropy(bad); }).find("unit vectors"), std::string::npos);
}

// Moduli along the directions, from the stiffness of the sphere's average: 3.14 : 1.32 : 1.58 for strengths
// of 4, 1/4, 1 (ratio 1/4, so no volume term), by quadrature of <G N N N N>.
TEST(Strengths, RatioOfModuli) {
  const Vector3 sigma(4, 0.25, 1);
  const double mean = mean_strength(sigma);
  Eigen::Matrix3d c = Eigen::Matrix3d::Zero(); // normal stresses from normal strains
  const int rings = 400, spokes = 400;
  for (int k = 0; k < rings; ++k)
    for (int l = 0; l < spokes; ++l) {
      const double z = (k + 0.5) / rings, r = std::sqrt(1 - z * z),
                   angle = (l + 0.5) / spokes * 1.5707963267948966;
      const Vector3 n(r * std::cos(angle), r * std::sin(angle), z);
      const double g = strength_along(n, Matrix3::Identity(), sigma, mean);
      const Vector3 n2 = n.cwiseProduct(n);
      c += g * n2 * n2.transpose() / (rings * spokes);
    }
  const Matrix3 s = c.inverse();
  const Vector3 young(1 / s(0, 0), 1 / s(1, 1), 1 / s(2, 2)), base(Vector3::Constant(1 / 6.));
  report("E1 over the isotropic one", young[0] / base[0]);
  report("E2", young[1] / base[1]);
  report("E3", young[2] / base[2]);
  EXPECT_NEAR(young[0] / young[1], 3.14 / 1.32, 0.03);
  EXPECT_NEAR(young[0] / young[2], 3.14 / 1.58, 0.03);
}

} // namespace
} // namespace pliant::test
