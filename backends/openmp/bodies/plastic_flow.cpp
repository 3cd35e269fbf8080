// Rest lengths after the return; see kernels/plastic_flow.decl.
#include "kernels/plastic_flow.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// Of an end whose particle lets these shares of its strain stay. Both particles of a bond compute both ends,
/// from the same numbers.
template <class real>
PLIANT_INLINE real rest_after(real before, real x, real size, const Real4<real>& stays) {
  if (stays.y >= 1 && stays.z >= 1) return before;
  const real now = x * before, strain = (size - now) / now;
  const real stretch = 1 + (stays.y * stays.x + stays.z * (strain - stays.x));
  return smaller(larger(size / (x * larger(stretch, real(0.05))), real(0.05)), real(20));
}

} // namespace

template <class real> void plastic_flow(const kernels::plastic_flow::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local, slice = k.first_slice + local / 16, lane = local % 16;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    const Real4<real> own = k.flow[2 * std::size_t{i} + 1];
    real stiffness = 0;
    bool changed = false;
    for (uint row = k.slice_begin[slice]; row < k.slice_begin[slice + 1]; ++row) {
      const std::size_t entry = std::size_t{32} * row + lane;
      const uint j = k.bond[entry];
      if (j == i) continue;
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
      const real x = norm(unpack_bond(k.bond[entry + 16], k.unit)), size = norm(y);
      const Real4<real> other = k.flow[2 * std::size_t{j} + 1];
      const real before_out = k.rest[entry], before_in = k.rest[entry + 16];
      const real p_out = rest_after(before_out, x, size, own), p_in = rest_after(before_in, x, size, other);
      stiffness += own.w * k.weight[entry] / (p_out * p_out) + other.w * k.weight[entry + 16] / (p_in * p_in);
      if (p_out == before_out && p_in == before_in) continue;
      changed = true;
      k.rest[entry] = p_out;
      k.rest[entry + 16] = p_in;
    }
    if (changed) k.linear_start[i].w = stiffness;
  }
}

PLIANT_BODY(plastic_flow)

} // namespace pliant::openmp::PLIANT_ISA
