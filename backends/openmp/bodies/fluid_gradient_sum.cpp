// One row for the step; see kernels/fluid_gradient_sum.decl.
#include "kernels/fluid_gradient_sum.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/fluid_viscosity.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_gradient_sum(const kernels::fluid_gradient_sum::View<real>& k) {
  double inside = 0, uneven = 0, surface = 0; // one thread: the same bits for any number of them
  if (k.spread)
    for (std::size_t i = 0; i < k.place_count; ++i) {
      const Vec3<real> g = k.support * xyz(k.fluid_gradient[i]);
      const real mark = k.fluid_normal[i].w;
      if (mark < 0) {
        surface += 1;
      } else if (mark <= 1) {
        inside += 1;
        uneven += static_cast<double>(dot(g, g));
      }
    }
  real* const to = k.spread_row + std::size_t{8} * k.row;
  to[0] = static_cast<real>(inside);
  to[1] = static_cast<real>(uneven);
  to[2] = static_cast<real>(surface);
  if (!k.viscous) return;
  const real first = k.fluid_viscosity[VISCOSITY_FIRST];
  to[3] = k.fluid_viscosity[VISCOSITY_ITERATIONS];
  to[4] = first > 0 ? root(k.fluid_viscosity[VISCOSITY_LEFT] / first) : real(0);
}

PLIANT_BODY(fluid_gradient_sum)

} // namespace pliant::openmp::PLIANT_ISA
