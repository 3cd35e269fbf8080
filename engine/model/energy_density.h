// What a material stores and pulls with when its neighbourhood deforms homogeneously, in double and without
// any kernel: the reference that curves are drawn of and that tests hold the kernels to; and the classical
// laws in closed form beside it.
#pragma once

#include "engine/model/model.h"

#include <optional>

namespace pliant {

/// The rotation (determinant 1) that maximises tr(R^T S).
Matrix3 nearest_rotation(const Matrix3& s);

/// Bonds of one particle at rest.
struct BondSet {
  std::vector<Vector3> bond;    ///< xi; any unit of length: only directions and ratios count
  std::vector<double> weight;   ///< omega, sum 1
  std::vector<double> strength; ///< G of each bond (anisotropy); empty where all are 1
};

/// A particle deep inside a body on its lattice, with the weights that the scene's settings and the law give.
BondSet lattice_neighbourhood(const SimulationSettings& settings, const Material& material);
/// The average over the sphere of directions that a lattice stands for: Gauss-Legendre in the cosine of the
/// polar angle, equally spaced around; `order` points in the one, twice as many in the other. Polynomials of
/// degree below 2 `order` are exact.
BondSet sphere_neighbourhood(const Material& material, unsigned order = 24);

/// Energy and stress of one material in a neighbourhood whose bonds all follow Y = F xi.
class EnergyDensity {
public:
  /// Throws Error(usage) where the material's constants make no law.
  EnergyDensity(const Material& material, BondSet bonds);

  double value(const Matrix3& f) const;   ///< W, J/m3; 0 at rest
  Matrix3 stress(const Matrix3& f) const; ///< first Piola-Kirchhoff, P = dW/dF, Pa

private:
  struct State;
  State evaluate(const Matrix3& f) const;

  Material material_;
  Law law_;
  LawConstants constants_;
  StretchEnergy stretch_;
  BondSet bonds_;
};

/// Laws of continuum mechanics that a curve can be compared with.
enum class ClassicalLaw : std::uint8_t { linear, corotated, stvk, neo_hookean };
/// The one that the material's law approximates at any strain; nothing for laws that are their own.
std::optional<ClassicalLaw> classical_law(const Material& material);
const char* classical_name(ClassicalLaw law);

/// With Lame's constants of Young's modulus (Pa) and Poisson's ratio, e = sym(F) - 1, E = (F^T F - 1) / 2, R
/// the signed polar rotation:
///   linear       mu e : e + lambda / 2 (tr e)^2
///   corotated    mu |F - R|^2 + lambda / 2 (tr(R^T F) - 3)^2
///   stvk         mu E : E + lambda / 2 (tr E)^2
///   neo_hookean  mu / 2 (|F|^2 - 3) - mu ln J + lambda / 2 ln^2 J (Xu et al. 2018, Eq. 27); J > 0
double classical_energy(ClassicalLaw law, double young, double poisson, const Matrix3& f);  ///< J/m3
Matrix3 classical_stress(ClassicalLaw law, double young, double poisson, const Matrix3& f); ///< Pa

} // namespace pliant
