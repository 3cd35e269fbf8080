// What one step's solve keeps of the positions at its start; see kernels/corotated_begin.decl.
#include "kernels/corotated_begin.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_begin(const kernels::corotated_begin::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]);
    Mat3<real> s = zero_matrix<real>();
    Vec3<real> linear{0, 0, 0};
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real c_in) {
      const Vec3<real> y = xyz(k.position[j]) - yi;
      add_outer(s, c_out, y, xi);
      linear = linear + (c_out + c_in) * y;
    });
    for (uint r = 0; r < 3; ++r)
      for (uint c = 0; c < 3; ++c) k.shape[std::size_t{3 * r + c + 2} * k.stride + i] = s.m[r][c];
    k.linear_start[i] = {linear.x, linear.y, linear.z, k.linear_start[i].w};
  }
}

PLIANT_BODY(corotated_begin)

} // namespace pliant::openmp::PLIANT_ISA
