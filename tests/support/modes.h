// The lowest natural mode of a small body with held particles, from the engine's own forces in double.
#pragma once

#include "tests/support/bodies.h"

#include <Eigen/Eigenvalues>

namespace pliant::test {

struct Mode {
  double omega = 0;           ///< rad/s
  std::vector<Vector3> shape; ///< largest displacement 1; zero where held
};

inline Mode lowest_mode(const Stage& stage) {
  const auto device = open_double();
  Simulation simulation(*device, stage.scene, stage.model);
  const Points rest = simulation.positions();
  const std::vector<bool> free = stage.free_particles();
  std::vector<std::size_t> unknowns;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (free[i]) unknowns.push_back(i);
  const auto n = static_cast<Eigen::Index>(3 * unknowns.size());
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index column = 0; column < n; ++column) {
    std::vector<Vector3> v(rest.size(), Vector3::Zero());
    v[unknowns[static_cast<std::size_t>(column / 3)]][column % 3] = 1;
    const std::vector<Vector3> f = stiffness_times(simulation, rest, v, free, 1e-5 * stage.model.spacing);
    for (Eigen::Index row = 0; row < n; ++row)
      k(row, column) = f[unknowns[static_cast<std::size_t>(row / 3)]][row % 3];
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen((k + k.transpose()) / 2); // equal masses
  Mode mode;
  mode.omega = std::sqrt(eigen.eigenvalues()[0] / stage.model.mass[0]);
  mode.shape.assign(rest.size(), Vector3::Zero());
  for (Eigen::Index row = 0; row < n; ++row)
    mode.shape[unknowns[static_cast<std::size_t>(row / 3)]][row % 3] = eigen.eigenvectors()(row, 0);
  const double size = largest(mode.shape);
  for (Vector3& v : mode.shape) v /= size;
  return mode;
}

} // namespace pliant::test
