// What has run into a sink is taken out; see kernels/fluid_sink.decl.
#include "kernels/fluid_sink.h"
#include "backends/openmp/body.h"
#include "backends/openmp/obstacle.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <class real> PLIANT_INLINE bool holds(const Real4<real>* __restrict row, Vec3<real> place) {
  const Vec3<real> from = place - xyz(row[OBSTACLE_CENTRE]);
  const auto* axes = row + OBSTACLE_AXES;
  Place<real> p;
  p.a = p.now = from.x * xyz(axes[0]) + from.y * xyz(axes[1]) + from.z * xyz(axes[2]); // R^T from
  p.u = {0, 0, 0};
  return shape_distance(static_cast<int>(row[OBSTACLE_KIND].x), p, xyz(row[OBSTACLE_SIZE])).d < 0;
}

} // namespace

template <class real> void fluid_sink(const kernels::fluid_sink::View<real>& k) {
  const Vec3<real> base{k.base_x, k.base_y, k.base_z};
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const auto y = k.position[i];
    if (y.w == 0) continue;
    const Vec3<real> place = (xyz(k.origin[k.fluid_kind[i] & FLUID_BODY]) - base) + xyz(y);
    for (uint s = 0; s < k.sinks; ++s) {
      if (!holds<real>(k.sink + OBSTACLE_ROWS * s, place)) continue;
      k.position[i] = {y.x, y.y, y.z, 0};
      k.velocity[i] = {0, 0, 0, 0};
      __atomic_fetch_add(&k.sunk[s], 1u, __ATOMIC_RELAXED); // a sum of counts: order does not matter
      break;
    }
  }
}

PLIANT_BODY(fluid_sink)

} // namespace pliant::openmp::PLIANT_ISA
