// Shape tensors and their inverses.
#include "engine/model/shape_tensor.h"

#include <Eigen/Eigenvalues>

namespace pliant {

ShapeTensor shape_tensor(const Model& model, std::uint32_t i) {
  Matrix3 tensor = Matrix3::Zero();
  for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
    const Vector3 n = (model.reference[model.bonds.neighbour[b]] - model.reference[i]).normalized();
    tensor += model.bonds.weight[b] * n * n.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(tensor);
  ShapeTensor result;
  for (int k = 0; k < 3; ++k) { // ascending
    const double value = eigen.eigenvalues()[k];
    if (!(value > shape_cutoff * tensor.trace())) continue;
    if (result.rank++ == 0) result.least = value;
    const Vector3 axis = eigen.eigenvectors().col(k);
    result.inverse += axis * axis.transpose() / value;
  }
  return result;
}

} // namespace pliant
