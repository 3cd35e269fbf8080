// Multipliers of Newton's method; see kernels/fluid_newton.decl.
#include "kernels/fluid_newton.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "backends/openmp/smoothing.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void fluid_newton(const kernels::fluid_newton::View<real>& k) {
  const Wide<real> none{}, one = none + 1;
  const real per_support = 1 / k.support;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> place = gather(k.fluid_place, part.index), g4 = gather(k.fluid_gradient, part.index);
    const Wide3<real> g{g4.x, g4.y, g4.z};
    const Wide<real> mark = magnitudes<real>(gather(k.fluid_normal, part.index).w);
    Wide3<real> own{};
    Wide<real> squares{};
    for_each_near(k, part, place, [&](const uint*, const Wide4<real>& d, WideMask<real> self) {
      const Wide<real> far = root_wide<real>(d.x * d.x + d.y * d.y + d.z * d.z), q = far * per_support;
      const Wide<real> per_far = 1 / (far > 0 ? far : one);
      const Wide3<real> n{per_far * d.x, per_far * d.y, per_far * d.z};
      const Wide<real> steep = k.slope_scale * spiky_slope<Wide<real>>(q, 1 / q), slope = self ? none : steep;
      const Wide<real> along = (k.curvature_scale * spiky_curvature(q) - slope) * dot(n, g);
      const Wide3<real> h{slope * g.x + along * n.x, slope * g.y + along * n.y, slope * g.z + along * n.z};
      own.x += h.x, own.y += h.y, own.z += h.z;
      squares += d.w > 0 ? dot(h, h) : none;
    });
    const Wide<real> size = dot(g, g), all = dot(own, own) + squares + k.softness * size;
    const Wide<real> whole = size / (all > 0 ? all : one);
    Wide<real> tau = mark <= 1 ? whole : none, share = k.rate * mark;
    const Wide<real> alone = tau * root_wide<real>(dot(own, own)), most = k.limit / (alone > 0 ? alone : one);
    share = share * alone > k.limit ? most : share;
    tau *= share;
    store(k.fluid_newton + first, part.count, Wide4<real>{tau * g.x, tau * g.y, tau * g.z, tau});
  }
}

PLIANT_BODY(fluid_newton)

} // namespace pliant::openmp::PLIANT_ISA
