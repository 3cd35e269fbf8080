// End of a step; see kernels/advance.decl.
#include "kernels/advance.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void advance(const kernels::advance::View<real>& k) {
  const Vec3<real> gravity{k.gravity_x, k.gravity_y, k.gravity_z};
  const real g2 = dot(gravity, gravity);
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    const Vec3<real> u = xyz(k.displacement[i]);
    const auto v_old = k.velocity[i];
    Vec3<real> shift = u; // y_(n+1) - y_bar
    if (k.bdf2) shift = shift - real(1) / 3 * xyz(k.earlier_shift[i]);
    if (k.history) {
      k.earlier_velocity[i] = v_old;
      k.earlier_shift[i] = {u.x, u.y, u.z, 0};
    }
    const Vec3<real> v = (1 / k.time_step) * shift;
    real felt = 0;
    if (g2 > 0) felt = smaller(larger(dot(v - xyz(v_old), gravity) / (k.time_step * g2), real(0)), real(1));
    k.velocity[i] = {v.x, v.y, v.z, felt};
    auto& y = k.position[i];
    y = {y.x + u.x, y.y + u.y, y.z + u.z, y.w};
  }
}

PLIANT_BODY(advance)

} // namespace pliant::openmp::PLIANT_ISA
