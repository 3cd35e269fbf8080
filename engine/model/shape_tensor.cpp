// Shape tensors and their inverses.
#include "engine/model/shape_tensor.h"

#include "engine/core/error.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

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

void require_solid(const Scene& scene, const Model& model) {
  std::vector<std::size_t> flat(model.bodies.size(), 0);
  for (const LawRange& range : model.laws) {
    if (range.law != Law::neo_hookean) continue;
    for (std::uint32_t i = range.first; i < range.first + range.count; ++i) {
      const int rank = shape_tensor(model, i).rank;
      if (rank > 0 && rank < 3) ++flat[model.body[i]];
    }
  }
  for (std::size_t b = 0; b < flat.size(); ++b)
    if (flat[b] > 0)
      throw Error(
          ExitCode::usage,
          fmt::format("{}{}: body '{}': law \"neo-hookean\" in its exact form needs neighbours in all "
                      "three directions, and those of {} of {} particles lie in a plane or along a "
                      "line; use a smaller spacing, form = \"bonds\", or law = \"corotated\"",
                      scene.file.string(), scene.bodies[b].typed_at, model.bodies[b].name, flat[b],
                      model.bodies[b].count));
}

} // namespace pliant
