// Smoothing functions of fluids: the cubic spline for densities, Spiky (Desbrun and Gascuel 1996) for the
// spreading of particles, and Mueller et al.'s (2003) for viscosity, of which only the Laplacian is used. All
// end at `support`.
//
//   value(r) = factor w(r / support), with w of shaders/common/smoothing.glsl and these factors, so that the
//   integral over space (or the plane, in two dimensions) of a value is 1 and that of r^2 / (2 d) times the
//   Laplacian is 1
//
// On a lattice of `spacing` the sums that stand for these integrals differ from 1, at a support of 2.1
// spacings by some percent: what must hold at rest is measured against the lattice's sums, below.
#pragma once

#include <cmath>
#include <numbers>

namespace pliant {

struct Smoothing {
  double support = 0; ///< m
  int dimension = 3;

  /// 1/m^d: factor of spline_value(); the gradient is spline_gradient() * spline_slope() * y.
  double spline() const {
    const double h = support, pi = std::numbers::pi;
    return dimension == 2 ? 40 / (7 * pi * h * h) : 8 / (pi * h * h * h);
  }
  double spline_gradient() const { return spline() / (support * support); }
  /// 1/m^d: factor of (1 - q)^3.
  double spiky() const {
    const double h = support, pi = std::numbers::pi;
    return dimension == 2 ? 10 / (pi * h * h) : 15 / (pi * h * h * h);
  }
  /// Of spiky_slope() * y, and of spiky_curvature().
  double spiky_gradient() const { return spiky() / (support * support); }
  /// 1/m^(d+2): factor of viscous_laplacian().
  double viscous() const {
    const double h = support, pi = std::numbers::pi;
    return dimension == 2 ? 40 / (pi * std::pow(h, 4)) : 45 / (pi * std::pow(h, 5));
  }

  double spline_value(double r) const {
    const double q = r / support;
    if (q >= 1) return 0;
    return spline() * (q < 0.5 ? 6 * q * q * (q - 1) + 1 : 2 * std::pow(1 - q, 3));
  }
  /// Derivative by r.
  double spline_derivative(double r) const {
    const double q = r / support;
    if (q >= 1) return 0;
    return spline() / support * (q < 0.5 ? 18 * q * q - 12 * q : -6 * (1 - q) * (1 - q));
  }
  double spiky_value(double r) const { return r < support ? spiky() * std::pow(1 - r / support, 3) : 0; }
  double spiky_derivative(double r) const {
    return r < support ? -3 * spiky() / support * std::pow(1 - r / support, 2) : 0;
  }
  double viscous_laplacian(double r) const { return r < support ? viscous() * (1 - r / support) : 0; }

  /// Sum of `of(r)` over the points of a lattice, the one at r = 0 first; times spacing^d it stands for the
  /// integral.
  template <class Of> double lattice_sum(double spacing, Of of) const {
    double sum = of(0.);
    for_lattice(spacing, [&](double, double, double r) { sum += of(r); });
    return sum;
  }
  /// 1/m^d: sum of spline_value(): a rest density over a particle's mass.
  double lattice_density(double spacing) const {
    return lattice_sum(spacing, [&](double r) { return spline_value(r); });
  }
  /// Sum over the neighbours of spacing^d r^2 / (2 d) viscous_laplacian(r): what viscosities are divided by,
  /// so that a lattice sheared slowly resists as the viscosity typed.
  double lattice_viscosity(double spacing) const {
    return std::pow(spacing, dimension) *
           lattice_sum(spacing, [&](double r) { return r * r / (2 * dimension) * viscous_laplacian(r); });
  }
  /// The same of forces along the line of centres: with u_x = g y a pair's is along n and as n_x n_y g r, so
  /// that the shear stress has the fourth moment, the sum of spacing^d r^2 / 2 n_x^2 n_y^2
  /// viscous_laplacian(r). Over all directions of shear its mean is lattice_viscosity() / (d + 2); along the
  /// axes of a cubic lattice of 2.1 spacings it is 2.9 % more.
  double lattice_central_viscosity(double spacing) const {
    double sum = 0;
    for_lattice(spacing, [&](double x, double y, double r) {
      sum += x * x * y * y / (2 * r * r) * viscous_laplacian(r);
    });
    return std::pow(spacing, dimension) * sum;
  }

private:
  /// Calls visit(x, y, r) for the points of a lattice within the support, but for the one at r = 0.
  template <class Visit> void for_lattice(double spacing, Visit visit) const {
    const int reach = static_cast<int>(support / spacing), deep = dimension == 2 ? 0 : reach;
    for (int z = -deep; z <= deep; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const double r = spacing * std::sqrt(double(x * x + y * y + z * z));
          if (r > 0 && r < support) visit(spacing * x, spacing * y, r);
        }
  }
};

} // namespace pliant
