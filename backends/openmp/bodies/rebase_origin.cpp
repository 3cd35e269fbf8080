// A body takes its origin along; see kernels/rebase_origin.decl.
#include "kernels/rebase_origin.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <class real> real multiple(real x, real quantum) {
  const real shift = quantum * static_cast<real>(__builtin_rint(static_cast<double>(x / quantum)));
  return __builtin_isfinite(shift) ? shift : 0;
}

} // namespace

template <class real> void rebase_origin(const kernels::rebase_origin::View<real>& k) {
  for (uint b = 0; b < k.threads; ++b) {
    const auto y = k.position[k.anchor[b]];
    auto& o = k.origin[b];
    const Vec3<real> shift{multiple(y.x, o.w), multiple(y.y, o.w), multiple(y.z, o.w)};
    o = {o.x + shift.x, o.y + shift.y, o.z + shift.z, o.w};
    k.origin_shift[b] = {shift.x, shift.y, shift.z, 0};
  }
}

PLIANT_BODY(rebase_origin)

} // namespace pliant::openmp::PLIANT_ISA
