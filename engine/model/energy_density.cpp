// Energy densities and stresses of homogeneous deformations.
#include "engine/model/energy_density.h"

#include "engine/core/error.h"
#include "engine/model/anisotropy.h"
#include "engine/model/lame.h"
#include "engine/model/moments.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <cmath>
#include <numbers>

namespace pliant {

Matrix3 nearest_rotation(const Matrix3& s) {
  const Eigen::JacobiSVD<Matrix3> svd(s, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3 u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  return u * svd.matrixV().transpose();
}

namespace {

Matrix3 cofactor(const Matrix3& f) {
  Matrix3 c;
  for (int k = 0; k < 3; ++k) c.col(k) = f.col((k + 1) % 3).cross(f.col((k + 2) % 3));
  return c;
}

/// Points and weights on [-1, 1] by Newton's method on the Legendre polynomial.
std::vector<std::array<double, 2>> gauss_legendre(unsigned order) {
  std::vector<std::array<double, 2>> rule;
  const double n = order;
  for (unsigned k = 0; k < order; ++k) {
    double x = std::cos(std::numbers::pi * (k + 0.75) / (n + 0.5)), slope = 1;
    for (int round = 0; round < 50; ++round) {
      double before = 1, now = x;
      for (unsigned l = 2; l <= order; ++l) {
        const double next = ((2.0 * l - 1) * x * now - (l - 1.0) * before) / l;
        before = now, now = next;
      }
      slope = n * (x * now - before) / (x * x - 1);
      const double step = now / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    rule.push_back({x, 2 / ((1 - x * x) * slope * slope)});
  }
  return rule;
}

/// G of every bond of a particle where a field's radial direction is across the axis.
void strengthen(const Material& material, BondSet& bonds) {
  const Anisotropy& anisotropy = material.anisotropy;
  if (!anisotropy.given) return;
  const Vector3 place = anisotropy.around_through + anisotropy.around_axis.unitOrthogonal();
  const Matrix3 directions = directions_at(anisotropy, place);
  const double mean = mean_strength(anisotropy.strengths);
  for (const Vector3& bond : bonds.bond)
    bonds.strength.push_back(strength_along(bond.normalized(), directions, anisotropy.strengths, mean));
}

} // namespace

BondSet lattice_neighbourhood(const SimulationSettings& settings, const Material& material) {
  const int reach = static_cast<int>(std::ceil(settings.horizon));
  std::vector<GridVector> vectors;
  BondSet result;
  for (int z = -reach; z <= reach; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const Vector3 step(x, y, z);
        if (step.norm() == 0 || !(step.norm() < settings.horizon)) continue;
        vectors.push_back({x * reference_grid, y * reference_grid, z * reference_grid});
        result.bond.push_back(settings.spacing * step);
      }
  result.weight = neighbourhood_weights(vectors, influence_of(settings, settings.horizon),
                                        moment_order(law_of(material)), settings.weights == "matched")
                      .weight;
  strengthen(material, result);
  return result;
}

BondSet sphere_neighbourhood(const Material& material, unsigned order) {
  BondSet result;
  const unsigned around = 2 * order;
  for (const auto& [cosine, weight] : gauss_legendre(order))
    for (unsigned k = 0; k < around; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.5) / around, sine = std::sqrt(1 - cosine * cosine);
      result.bond.emplace_back(sine * std::cos(angle), sine * std::sin(angle), cosine);
      result.weight.push_back(weight / 2 / around);
    }
  strengthen(material, result);
  return result;
}

struct EnergyDensity::State {
  double value = 0;
  Matrix3 stress = Matrix3::Zero();
};

EnergyDensity::EnergyDensity(const Material& material, BondSet bonds)
    : material_(material), law_(law_of(material)), constants_(law_constants(material)),
      stretch_(stretch_energy(material)), bonds_(std::move(bonds)) {
  const BondSet& n = bonds_;
  if (n.bond.empty() || n.bond.size() != n.weight.size() ||
      (!n.strength.empty() && n.strength.size() != n.bond.size()))
    throw Error(ExitCode::internal, "a neighbourhood without bonds, or with lists of different lengths");
}

double EnergyDensity::value(const Matrix3& f) const {
  return evaluate(f).value;
}

Matrix3 EnergyDensity::stress(const Matrix3& f) const {
  return evaluate(f).stress;
}

EnergyDensity::State EnergyDensity::evaluate(const Matrix3& f) const {
  const BondSet& n = bonds_;
  State result;
  const auto each = [&](auto visit) { // weight, xi / x, Y / x, strength of every bond
    for (std::size_t b = 0; b < n.bond.size(); ++b) {
      const Vector3 direction = n.bond[b].normalized();
      visit(n.weight[b], direction, Vector3(f * direction), n.strength.empty() ? 1.0 : n.strength[b]);
    }
  };
  switch (law_) {
  case Law::corotated: {
    const double mu = constants_.modulus / 2, kappa = mu * constants_.coupling;
    Matrix3 s = Matrix3::Zero();
    each([&](double w, const Vector3& x, const Vector3& y, double) { s += w * y * x.transpose(); });
    const Matrix3 r = nearest_rotation(s);
    double theta = 0;
    each([&](double w, const Vector3& x, const Vector3& y, double) { theta += w * y.dot(r * x); });
    result.value = kappa * (theta - 1) * (theta - 1);
    each([&](double w, const Vector3& x, const Vector3& y, double) {
      const Vector3 off = y - r * x;
      result.value += mu * w * off.squaredNorm();
      result.stress += 2 * w * (mu * off + kappa * (theta - 1) * (r * x)) * x.transpose();
    });
    break;
  }
  case Law::neo_hookean: { // every bond follows the gradient, whatever the weights
    const double mu = constants_.modulus / 3, lambda = mu * (1 + constants_.coupling / 1.5);
    const double growth = f.determinant() - 1;
    result.value = mu / 2 * (f.squaredNorm() - 3) - mu * growth + lambda / 2 * growth * growth;
    result.stress = mu * f + (lambda * growth - mu) * cofactor(f);
    break;
  }
  case Law::fluid: // what a fluid stores is no function of its deformation
    break;
  case Law::ordinary:
  case Law::projective:
  case Law::basis: {
    const double stiffness = constants_.modulus / 2;
    // Both older laws are sums of B_1 = (s - 1)^2.
    StretchEnergy energy = stretch_;
    if (law_ != Law::basis) {
      energy = {};
      energy.bond = {{parse_basis("B1")}};
      if (law_ == Law::ordinary && constants_.coupling != 0)
        energy.volume = energy.bond.scaled(constants_.coupling);
    }
    double mean = 0, square = 0;
    each([&](double w, const Vector3&, const Vector3& y, double) {
      mean += w * y.norm();
      square += w * y.squaredNorm();
    });
    const double theta = energy.squared ? std::sqrt(square) : mean;
    result.value = stiffness * energy.volume.value(theta);
    const double pull = energy.volume.first(theta);
    each([&](double w, const Vector3& x, const Vector3& y, double strength) {
      const double s = y.norm(), rate = energy.squared ? s / theta : 1;
      result.value += stiffness * w * strength * energy.bond.value(s);
      if (s > 0)
        result.stress +=
            stiffness * w * (pull * rate + strength * energy.bond.first(s)) / s * y * x.transpose();
    });
    break;
  }
  }
  return result;
}

std::optional<ClassicalLaw> classical_law(const Material& material) {
  if (material.law == "corotated") return ClassicalLaw::corotated;
  if (material.law == "stvk") return ClassicalLaw::stvk;
  if (material.law == "neo-hookean") return ClassicalLaw::neo_hookean;
  if (material.law == "ordinary" || material.law == "projective") return ClassicalLaw::linear;
  return {};
}

const char* classical_name(ClassicalLaw law) {
  switch (law) {
  case ClassicalLaw::linear:
    return "linear";
  case ClassicalLaw::corotated:
    return "corotated linear";
  case ClassicalLaw::stvk:
    return "St. Venant-Kirchhoff";
  case ClassicalLaw::neo_hookean:
    return "neo-Hookean";
  }
  return "unknown";
}

double classical_energy(ClassicalLaw law, double young, double poisson, const Matrix3& f) {
  const Lame c = lame_constants(young, poisson);
  const Matrix3 one = Matrix3::Identity();
  switch (law) {
  case ClassicalLaw::linear:
  case ClassicalLaw::corotated: {
    const Matrix3 r = law == ClassicalLaw::linear ? one : nearest_rotation(f);
    const Matrix3 g = r.transpose() * f - one, e = (g + g.transpose()) / 2;
    return c.mu * e.squaredNorm() + c.lambda / 2 * e.trace() * e.trace();
  }
  case ClassicalLaw::stvk: {
    const Matrix3 e = (f.transpose() * f - one) / 2;
    return c.mu * e.squaredNorm() + c.lambda / 2 * e.trace() * e.trace();
  }
  case ClassicalLaw::neo_hookean: {
    const double log = std::log(f.determinant());
    return c.mu / 2 * (f.squaredNorm() - 3) - c.mu * log + c.lambda / 2 * log * log;
  }
  }
  return 0;
}

Matrix3 classical_stress(ClassicalLaw law, double young, double poisson, const Matrix3& f) {
  const Lame c = lame_constants(young, poisson);
  const Matrix3 one = Matrix3::Identity();
  switch (law) {
  case ClassicalLaw::linear:
  case ClassicalLaw::corotated: {
    const Matrix3 r = law == ClassicalLaw::linear ? one : nearest_rotation(f);
    const Matrix3 g = r.transpose() * f - one, e = (g + g.transpose()) / 2;
    return r * (2 * c.mu * e + c.lambda * e.trace() * one);
  }
  case ClassicalLaw::stvk: {
    const Matrix3 e = (f.transpose() * f - one) / 2;
    return f * (2 * c.mu * e + c.lambda * e.trace() * one);
  }
  case ClassicalLaw::neo_hookean: {
    const double j = f.determinant();
    return c.mu * f + (c.lambda * std::log(j) - c.mu) / j * cofactor(f);
  }
  }
  return Matrix3::Zero();
}

} // namespace pliant
