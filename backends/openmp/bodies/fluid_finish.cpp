// End of a step of a fluid; see kernels/fluid_finish.decl.
#include "kernels/fluid_finish.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/fluid.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

// One direction of the domain: whether a place has left it, and where it is inside.
template <class real> struct Extent {
  real low, high, period;
  PLIANT_INLINE bool lost(real at) const { return period == 0 && (at < low || at > high); }
  PLIANT_INLINE real inside(real at) const {
    if (!(period > 0) || (at >= low && at < low + period)) return at;
    const real turns = (at - low) / period;
    if (!(turns > real(-1e9) && turns < real(1e9))) return at;
    const real cut = static_cast<real>(static_cast<int>(turns));
    return at - period * (cut > turns ? cut - 1 : cut);
  }
};

} // namespace

template <class real> void fluid_finish(const kernels::fluid_finish::View<real>& k) {
  const Extent<real> x{k.low_x, k.high_x, k.period_x}, y{k.low_y, k.high_y, k.period_y},
      z{k.low_z, k.high_z, k.period_z};
  constexpr real most = real(1e30);
#pragma omp parallel for schedule(static)
  for (uint place = 0; place < k.threads; ++place) {
    const auto at = k.fluid_place[place];
    const uint i = k.fluid_particle[place];
    if (i >= k.particle_count || at.w == 0) continue; // a ghost, or removed before
    Vec3<real> end = xyz(at), v = xyz(k.fluid_velocity[place]);
    real mass = at.w, w;
    if (mass < 0) {
      mass = -mass;
      w = larger(k.velocity[i].w - k.time_step, real(0));
    } else {
      w = smaller(k.fluid_total[place], real(0)) / (k.time_step * k.time_step);
    }
    if (k.bounded) {
      const bool finite = magnitude(end.x) < most && magnitude(end.y) < most && magnitude(end.z) < most;
      if (finite && (x.lost(end.x) || y.lost(end.y) || z.lost(end.z))) {
        mass = 0;
        v = {0, 0, 0};
        w = 0;
      }
      end = {x.inside(end.x), y.inside(end.y), z.inside(end.z)};
    }
    const Vec3<real> body =
        xyz(k.origin[k.fluid_kind[i] & FLUID_BODY]) - Vec3<real>{k.base_x, k.base_y, k.base_z};
    end = end - body;
    k.position[i] = {end.x, end.y, end.z, mass};
    k.velocity[i] = {v.x, v.y, v.z, w};
  }
}

PLIANT_BODY(fluid_finish)

} // namespace pliant::openmp::PLIANT_ISA
