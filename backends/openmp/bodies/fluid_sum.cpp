// One row for the step; see kernels/fluid_sum.decl.
#include "kernels/fluid_sum.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_sum(const kernels::fluid_sum::View<real>& k) {
  double inside = 0, error = 0, steep = 0, excess = 0,
         all = 0; // one thread: the same bits for any number of them
  real largest = -1;
  uint removed = 0;
  for (std::size_t i = 0; i < k.place_count; ++i) {
    const auto seen = k.fluid_measure[i];
    if (seen.w == 0) continue;
    inside += static_cast<double>(seen.z);
    error += static_cast<double>(seen.z * magnitude(seen.x));
    steep += static_cast<double>(seen.y);
    excess += static_cast<double>(larger(seen.x, real(0)));
    all += 1;
    largest = larger(largest, seen.x);
  }
  for (std::size_t i = 0; i < k.particle_count; ++i) removed += k.position[i].w == 0;
  real* const to = k.fluid_row + std::size_t{8} * k.row;
  to[0] = static_cast<real>(inside);
  to[1] = static_cast<real>(error);
  to[2] = largest;
  to[3] = static_cast<real>(steep);
  to[4] = static_cast<real>(removed);
  to[5] = static_cast<real>(k.left_out[0]);
  to[6] = static_cast<real>(k.left_out[1]);
  to[7] = static_cast<real>(all > 0 ? excess / all : 0);
}

PLIANT_BODY(fluid_sum)

} // namespace pliant::openmp::PLIANT_ISA
