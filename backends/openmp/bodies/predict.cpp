// The inertia target y* of Eq. 12 and the first guess; see kernels/predict.decl.
#include "kernels/predict.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void predict(const kernels::predict::View<real>& k) {
  const Vec3<real> gravity{k.gravity_x, k.gravity_y, k.gravity_z};
  const real h = k.time_step, third = real(1) / 3;
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const real mass = k.position[i].w;
    const auto v = k.velocity[i];
    Vec3<real> acceleration = gravity, start{0, 0, 0}, drift = xyz(v);
    if (k.loaded) acceleration = acceleration + (1 / mass) * xyz(k.external_force[i]);
    if (k.bdf2) {
      start = third * xyz(k.earlier_shift[i]);
      drift = third * (real(4) * xyz(v) - xyz(k.earlier_velocity[i]));
    }
    const Vec3<real> target = start + h * drift + h * h * acceleration;
    // At rest a step starts at rest, in free flight at its target: gravity counts as far as it was felt
    // before.
    const Vec3<real> guess = target - (1 - v.w) * (h * h) * gravity;
    k.inertia_target[i] = {target.x, target.y, target.z, mass / (h * h)};
    k.displacement[i] = {guess.x, guess.y, guess.z, 0};
  }
}

PLIANT_BODY(predict)

} // namespace pliant::openmp::PLIANT_ISA
