// predict on the CPU: y* of Eq. 12 as a displacement from the start of the step, and where the solve begins.
//
// With k.step = h (implicit Euler) the state at the start is y = 0, v. BDF2 solves the same problem with
// k.step = 2h/3 and the start moved to ybar = (4 y^n - y^(n-1))/3 and vbar = (4 v^n - v^(n-1))/3; measured
// from y^n, ybar is a third of the last displacement.
#include "backends/openmp/body.h"

#include "kernels/predict.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void predict(const kernels::predict::View<real>& k) {
  using real4 = Real4<real>;
  const std::uint32_t count = k.threads < k.particle_count ? k.threads : k.particle_count;
  const real square = k.step * k.step;
  const real third = real(1) / real(3);
#pragma omp parallel for schedule(static)
  for (std::uint32_t i = 0; i < count; ++i) {
    const real4 force = k.external_force[i];
    const real mass = force.w;
    if (mass <= 0) { // held: another kernel moves it
      k.inertia_target[i] = k.displacement[i] = k.earlier_iterate[i] = real4{0, 0, 0, 0};
      continue;
    }
    const real4 velocity = k.velocity[i];
    real start_x = 0, start_y = 0, start_z = 0;
    real drift_x = velocity.x, drift_y = velocity.y, drift_z = velocity.z;
    if (k.bdf2) {
      const real4 shift = k.earlier_shift[i];
      const real4 earlier = k.earlier_velocity[i];
      start_x = third * shift.x;
      start_y = third * shift.y;
      start_z = third * shift.z;
      drift_x = third * (4 * velocity.x - earlier.x);
      drift_y = third * (4 * velocity.y - earlier.y);
      drift_z = third * (4 * velocity.z - earlier.z);
    }
    const real target_x = start_x + k.step * drift_x + square * (k.gravity_x + force.x / mass);
    const real target_y = start_y + k.step * drift_y + square * (k.gravity_y + force.y / mass);
    const real target_z = start_z + k.step * drift_z + square * (k.gravity_z + force.z / mass);
    // Gravity that the last step did not give (resting bodies) is left out of the guess.
    const real unfelt = (1 - velocity.w) * square;
    const real4 guess{target_x - unfelt * k.gravity_x, target_y - unfelt * k.gravity_y,
                      target_z - unfelt * k.gravity_z, 0};
    k.inertia_target[i] = real4{target_x, target_y, target_z, mass / square};
    k.displacement[i] = guess;
    k.earlier_iterate[i] = guess;
  }
}
PLIANT_BODY(predict)

} // namespace pliant::openmp::PLIANT_ISA
