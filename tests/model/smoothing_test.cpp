// Smoothing functions: their integrals, their derivatives, and what a lattice makes of them.
#include "engine/model/smoothing.h"
#include "tests/support/bodies.h"

namespace pliant::test {
namespace {

// Integral over space or the plane, midpoint rule.
template <class Of> double integral(const Smoothing& of_what, Of of) {
  constexpr int parts = 20000;
  const double dr = of_what.support / parts, pi = std::numbers::pi;
  double sum = 0;
  for (int k = 0; k < parts; ++k) {
    const double r = (k + 0.5) * dr;
    sum += of(r) * (of_what.dimension == 2 ? 2 * pi * r : 4 * pi * r * r) * dr;
  }
  return sum;
}

TEST(Smoothing, IntegralsAreOne) {
  for (const int dimension : {2, 3}) {
    const Smoothing s{0.042, dimension};
    const std::string in = " in " + std::to_string(dimension) + " dimensions: integral - 1";
    const auto check = [&](const std::string& what, double value) {
      expect_below(what + in, std::abs(value - 1), 1e-7); // (dr / support)^2, times a few
    };
    check("spline", integral(s, [&](double r) { return s.spline_value(r); }));
    check("Spiky", integral(s, [&](double r) { return s.spiky_value(r); }));
    check("r^2 of the Laplacian",
          integral(s, [&](double r) { return r * r / (2 * dimension) * s.viscous_laplacian(r); }));
  }
}

TEST(Smoothing, DerivativesAreThoseOfTheValues) {
  for (const int dimension : {2, 3}) {
    const Smoothing s{1.5, dimension};
    double worst = 0;
    for (int k = 0; k < 115; ++k) {
      const double r = 0.03 + 0.0137 * k;
      const double step = 1e-5;
      worst = std::max(worst, std::abs(s.spline_derivative(r) -
                                       (s.spline_value(r + step) - s.spline_value(r - step)) / (2 * step)));
      worst = std::max(worst, std::abs(s.spiky_derivative(r) -
                                       (s.spiky_value(r + step) - s.spiky_value(r - step)) / (2 * step)));
    }
    expect_below("derivative - difference", worst, 1e-8);
  }
}

// At 2.1 spacings a lattice's sums are off by what this prints, and all right at 12.
TEST(Smoothing, SumsOverLattices) {
  for (const int dimension : {2, 3})
    for (const double horizon : {2.1, 12.0}) {
      const Smoothing s{horizon * 0.02, dimension};
      const double density = s.lattice_density(0.02) * std::pow(0.02, dimension) - 1,
                   viscosity = s.lattice_viscosity(0.02) - 1, limit = horizon > 10 ? 2e-3 : 0.2;
      expect_below("density of a lattice - 1", std::abs(density), limit);
      expect_below("viscosity of a lattice - 1", std::abs(viscosity), limit);
      expect_below("(d + 2) that of central forces - 1",
                   std::abs((dimension + 2) * s.lattice_central_viscosity(0.02) - 1), limit);
    }
  const Smoothing s{2.1, 3};
  // Sheared along its axes a lattice resists a little more than in the mean over all directions.
  EXPECT_NEAR(5 * s.lattice_central_viscosity(1) / s.lattice_viscosity(1), 1.0287, 1e-3);
  EXPECT_EQ(s.lattice_sum(1, [](double) { return 1.; }), 33); // 1 + 6 + 12 + 8 + 6
}

} // namespace
} // namespace pliant::test
