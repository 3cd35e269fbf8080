// Particles of fluids in sorted order with the lists of their neighbours by looking at all pairs, as kernels
// get them.
#pragma once

#include "engine/model/smoothing.h"
#include "shaders/common/fluid.glsl"
#include "tests/support/bodies.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {

struct NearCloud {
  double spacing = 0.0625, support = 0.13125; // 2.1 spacings, exact in float
  int dimension = 3;
  Vector3 period = Vector3::Zero(); // m; 0 where nothing repeats
  Points place;
  std::vector<double> mass;   // kg; negative: a ghost; 0: nothing there
  std::vector<double> fourth; // of fluid_velocity: material, of ghosts the height
  Points velocity;
  std::vector<double> traits = std::vector<double>(4 * FLUIDS * FLUID_ROWS, 0.0);

  double support_in_float() const { return rounded(support); }
  Smoothing smoothing() const { return {support_in_float(), dimension}; }
  double volume() const { return std::pow(spacing, dimension); }
  std::size_t places() const { return (place.size() + 15) / 16 * 16; }
  void add(const Vector3& at, double its_mass, double its_fourth, const Vector3& its_velocity) {
    place.push_back({rounded(at.x()), rounded(at.y()), rounded(at.z())});
    mass.push_back(its_mass);
    fourth.push_back(its_fourth);
    velocity.push_back({rounded(its_velocity.x()), rounded(its_velocity.y()), rounded(its_velocity.z())});
  }
  void material(std::size_t m, double viscosity, double redistribution, double tension) {
    const double row[] = {1000, viscosity, redistribution, tension};
    std::copy(row, row + 4,
              traits.begin() + static_cast<std::ptrdiff_t>(4 * (FLUID_ROWS * m + FLUID_TRAITS)));
  }
  double trait(std::size_t i, std::size_t which) const {
    return traits[4 * (FLUID_ROWS * static_cast<std::size_t>(fourth[i]) + FLUID_TRAITS) + which];
  }
  Vector3 between(std::size_t i, std::size_t j) const { // from j to i
    Vector3 d = place[i] - place[j];
    for (int a = 0; a < 3; ++a)
      if (period[a] > 0) d[a] -= period[a] * std::round(d[a] / period[a]);
    return d;
  }
  std::vector<std::vector<std::uint32_t>> lists() const {
    std::vector<std::vector<std::uint32_t>> found(place.size());
    for (std::uint32_t i = 0; i < place.size(); ++i)
      for (std::uint32_t j = 0; j < place.size(); ++j)
        if (i != j && mass[i] != 0 && mass[j] != 0 && between(i, j).norm() < support_in_float())
          found[i].push_back(j);
    return found;
  }
  /// near, near_count, rows, support, periods, fluid_place, fluid_velocity, fluid_material.
  Values values() const {
    const auto list = lists();
    std::size_t rows = 1;
    for (const auto& each : list) rows = std::max(rows, each.size());
    Values in;
    std::vector<double>&near = in["near"], &count = in["near_count"];
    near.resize(rows * places());
    count.resize(places() / 16);
    for (std::size_t i = 0; i < places(); ++i) {
      const std::size_t own = i < list.size() ? list[i].size() : 0, slice = i / 16;
      count[slice] = std::max(count[slice], static_cast<double>(own));
      for (std::size_t r = 0; r < rows; ++r)
        near[16 * (rows * slice + r) + i % 16] = static_cast<double>(r < own ? list[i][r] : i);
    }
    for (std::size_t i = 0; i < places(); ++i) {
      const bool there = i < place.size();
      const Vector3 at = there ? place[i] : Vector3::Constant(0x1p50),
                    v = there ? velocity[i] : Vector3::Zero();
      in["fluid_place"].insert(in["fluid_place"].end(), {at.x(), at.y(), at.z(), there ? mass[i] : 0});
      in["fluid_velocity"].insert(in["fluid_velocity"].end(), {v.x(), v.y(), v.z(), there ? fourth[i] : 0});
    }
    in["rows"] = {static_cast<double>(rows)};
    in["support"] = {support_in_float()};
    in["period_x"] = {period.x()}, in["period_y"] = {period.y()}, in["period_z"] = {period.z()};
    in["fluid_material"] = traits;
    return in;
  }
};

/// A cube of `n` particles an edge, jittered by `jitter` spacings, about the origin.
inline NearCloud jittered_cube(int n, double jitter, unsigned seed) {
  NearCloud cloud;
  Random random(seed);
  cloud.material(0, 0, 1, 0);
  for (const Vector3& p : lattice(n, n, n, cloud.spacing))
    cloud.add(p - Vector3::Constant(cloud.spacing * (n - 1) / 2.) + random.vector(jitter * cloud.spacing),
              0.25, 0, random.vector());
  return cloud;
}

/// What of `all` the kernel declares.
template <class Args> Values chosen(const Values& all, const Values& more = {}) {
  Values in;
  for (const Field& field : Args::info().fields) {
    if (const auto found = all.find(field.name); found != all.end()) in[field.name] = found->second;
    if (const auto found = more.find(field.name); found != more.end()) in[field.name] = found->second;
  }
  return in;
}

} // namespace pliant::test
