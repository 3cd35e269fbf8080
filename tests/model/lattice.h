// Lattices and materials that the tests of the model share.
#pragma once

#include "engine/model/model.h"

namespace pliant::test {

/// nx * ny * nz points at the spacing given, one corner at zero; x fastest.
inline std::vector<Vector3> block(int nx, int ny, int nz, double spacing) {
  std::vector<Vector3> points;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) points.push_back(Vector3(x, y, z) * spacing);
  return points;
}

inline Material material(const std::string& law, double young, double poisson) {
  Material made;
  made.name = law;
  made.law = law;
  made.young = young;
  made.poisson = poisson;
  return made;
}

/// Direction of a bond in the reference configuration.
inline Vector3 direction(const Model& model, std::uint32_t i, std::uint32_t bond) {
  return (model.reference[model.bonds.neighbour[bond]] - model.reference[i]).normalized();
}

/// Sum of w N N over a particle's bonds.
inline Matrix3 second_moment(const Model& model, std::uint32_t i) {
  Matrix3 sum = Matrix3::Zero();
  for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
    const Vector3 n = direction(model, i, b);
    sum += model.bonds.weight[b] * n * n.transpose();
  }
  return sum;
}

/// Sum of w n_x^p n_y^q n_z^r over a particle's bonds.
inline double moment(const Model& model, std::uint32_t i, int p, int q, int r) {
  double sum = 0;
  const auto power = [](double base, int exponent) {
    double value = 1;
    while (exponent-- > 0) value *= base;
    return value;
  };
  for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
    const Vector3 n = direction(model, i, b);
    sum += model.bonds.weight[b] * power(n.x(), p) * power(n.y(), q) * power(n.z(), r);
  }
  return sum;
}

} // namespace pliant::test
