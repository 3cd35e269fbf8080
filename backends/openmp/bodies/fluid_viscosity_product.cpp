// The matrix of viscosity; see kernels/fluid_viscosity_product.decl.
#include "kernels/fluid_viscosity_product.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "shaders/common/fluid_viscosity.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <bool central, class real>
PLIANT_INLINE void product(const kernels::fluid_viscosity_product::View<real>& k) {
  constexpr uint group = kernels::fluid_viscosity_product::group_size;
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < (k.threads + group - 1) / group; ++block) {
    real squares = 0, products = 0;
    for (uint first = group * block; first < smaller(group * (block + 1), k.threads); first += lanes<real>) {
      const Part<real> part = make_part<real>(first, k.threads - first);
      const Wide4<real> u = gather(k.fluid_residual, part.index);
      const Wide4<real> start = central ? gather(k.fluid_start, part.index) : Wide4<real>{};
      Wide3<real> w{u.x, u.y, u.z};
      const uint slice = first / 16;
      const std::size_t begin = std::size_t{16} * k.rows * slice + first % 16;
      for (uint r = 0; r < k.near_count[slice]; ++r) {
        const std::size_t at = begin + std::size_t{16} * r;
        __builtin_prefetch(k.near + at + std::size_t{16} * k.rows); // the next slice, on a page of its own
        __builtin_prefetch(k.near_rate + at + std::size_t{16} * k.rows);
        const Wide4<real> other = gather_near(k.fluid_residual, k.near + at);
        const Wide<real> rate = load_wide(k.near_rate + at);
        Wide3<real> faster{u.x - other.x, u.y - other.y, u.z - other.z};
        if constexpr (central) {
          const Wide3<real> arm = from_near(k, k.fluid_start, start, k.near + at);
          const Wide<real> along = dot(arm, faster);
          faster = {along * arm.x, along * arm.y, along * arm.z};
        }
        w.x += rate * faster.x, w.y += rate * faster.y, w.z += rate * faster.z;
      }
      store(k.fluid_image + first, part.count, Wide4<real>{w.x, w.y, w.z, {}});
      const Wide<real> square = u.w * (u.x * u.x + u.y * u.y + u.z * u.z);
      const Wide<real> image = u.w * (u.x * w.x + u.y * w.y + u.z * w.z);
      for (uint lane = 0; lane < part.count; ++lane) squares += square[lane], products += image[lane];
    }
    k.fluid_partial[block] = {squares, products, 0, 0};
  }
}

} // namespace

template <class real> void fluid_viscosity_product(const kernels::fluid_viscosity_product::View<real>& k) {
  if (k.fluid_viscosity[VISCOSITY_STOP] > 0) return;
  if (k.central)
    product<true>(k);
  else
    product<false>(k);
}

PLIANT_BODY(fluid_viscosity_product)

} // namespace pliant::openmp::PLIANT_ISA
