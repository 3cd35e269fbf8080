// Materials over basis functions, for tests.
#pragma once

#include "tests/support/bodies.h"

#include <map>

namespace pliant::test {

using Shares = std::map<std::string, double>;

inline Material basis_of(double young, double poisson, const Shares& g, const Shares& h) {
  Material made;
  made.name = "basis";
  made.law = "basis";
  made.young = young;
  made.poisson = poisson;
  made.volume_basis = g;
  made.bond_basis = h;
  return made;
}
inline Material formed(const std::string& law, const std::string& form, double young, double poisson) {
  Material made;
  made.name = law;
  made.law = law;
  made.form = form;
  made.young = young;
  made.poisson = poisson;
  return made;
}

struct NamedMaterial {
  std::string name;
  Material material;
};

/// The laws and a mixture.
inline std::vector<NamedMaterial> some_materials(double young, double poisson) {
  return {
      {"B1", basis_of(young, poisson, {{"B1", 1}}, {{"B1", 1}})},
      {"A4", basis_of(young, poisson, {{"A4", 1}}, {{"A4", 1}})},
      {"g A2, h A4 B1", basis_of(young, std::max(poisson, 0.25), {{"A2", 1}}, {{"A4", 0.5}, {"B1", 0.5}})},
      {"stvk exact", formed("stvk", "exact", young, poisson)},
      {"stvk bonds", formed("stvk", "bonds", young, poisson)},
      {"neo-hookean bonds", formed("neo-hookean", "bonds", young, poisson)}};
}

inline Anisotropy directions_of(const Vector3& strengths, const Matrix3& rows = Matrix3::Identity()) {
  Anisotropy made;
  made.given = true;
  made.strengths = strengths;
  made.directions = rows;
  return made;
}

inline double norm_of(const std::vector<Vector3>& v) {
  return std::sqrt(inner(v, v));
}

inline std::vector<Vector3> random_field(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Vector3> v(count);
  for (Vector3& one : v) one = random_vector(random);
  return v;
}

} // namespace pliant::test
