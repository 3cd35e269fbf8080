// Positions in the world; see kernels/frame_particles.decl.
#include "kernels/frame_particles.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

#include <limits>

namespace pliant::openmp::PLIANT_ISA {

template <class real> void frame_particles(const kernels::frame_particles::View<real>& k) {
  const Vec3<real> scene{k.scene_x, k.scene_y, k.scene_z};
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const Vec3<real> world = scene + xyz(k.origin[k.owner[i]]) + xyz(k.position[i]);
    real value = 0;
    switch (k.field) {
    case 1:
      value = norm(xyz(k.velocity[i]));
      break;
    case 2:
      value = k.gradient[3 * i].w;
      break;
    case 3:
      value = k.energy[i] / k.start[i].w;
      break;
    case 4:
      value = norm(world - xyz(k.start[i]));
      break;
    case 5:
      value = 1 - k.shape[k.share_at + i];
      break;
    case 6:
      value = k.flow[2 * std::size_t{i}].x;
      break;
    default:
      break;
    }
    if (k.gone && k.position[i].w == 0) {
      constexpr real never = std::numeric_limits<real>::infinity();
      k.particle[i] = {never, never, never, never};
      continue;
    }
    k.particle[i] = {world.x, world.y, world.z, value};
  }
}

PLIANT_BODY(frame_particles)

} // namespace pliant::openmp::PLIANT_ISA
