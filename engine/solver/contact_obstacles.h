// The scene's boundaries as the kernel boundary_contact wants them: a row of numbers each, distance grids for
// meshes.
#pragma once

#include "engine/model/distance_grid.h"
#include "engine/scene/scene.h"
#include "engine/solver/motion.h"
#include "kernels/kernel.h"

#include <cstdint>
#include <vector>

namespace pliant {

class Obstacles {
public:
  /// `radius`, m: how far outside an obstacle's surface centres of particles are kept. Reads meshes and
  /// samples their distance at `cell`, m, unless `measure_only`. Throws Error(usage): more boundaries than
  /// OBSTACLES; what ShapeQuery throws.
  Obstacles(const Scene& scene, double radius, double cell, bool measure_only = false);

  std::uint32_t count() const { return static_cast<std::uint32_t>(obstacles_.size()); }
  bool meshes() const { return grid_nodes_ > 0; }
  std::size_t grid_nodes() const { return grid_nodes_; }
  /// Rows for the table `obstacle`: places at `end`, relative to `origin` (m, world), displacements since
  /// `begin`, s. An obstacle that its motion has released by `end` touches nothing.
  std::vector<Real4<double>> table(double begin, double end, const Vector3& origin) const;
  /// The table `grid`, and the distances of all grids, one after the other, m; given away.
  std::vector<std::uint32_t> grid_table() const;
  std::vector<double> take_distances() { return std::move(distances_); }

private:
  struct Obstacle {
    double kind = 0, friction = 0;
    bool no_slip = false, inside = false;
    Vector3 centre = Vector3::Zero(); ///< m, world, before any motion
    Matrix3 axes = Matrix3::Identity();
    Vector3 size = Vector3::Zero(); ///< m
    double around = 0;              ///< m; radius about the centre beyond which nothing touches
    std::array<std::uint32_t, 4> grid{};
    Vector3 low = Vector3::Zero(); ///< m, own axes
    double cell = 1;
    Motion motion;
  };
  std::vector<Obstacle> obstacles_;
  std::vector<double> distances_;
  std::size_t grid_nodes_ = 0;
};

} // namespace pliant
