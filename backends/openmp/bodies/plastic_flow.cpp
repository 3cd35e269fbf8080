// Rest lengths after the return; see kernels/plastic_flow.decl.
#include "kernels/plastic_flow.h"
#include "backends/openmp/body.h"
#include "backends/openmp/bond_wide.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// Of ends whose particles let these shares of their strain stay. Both particles of a bond compute both ends,
/// from the same numbers. Padding has no length and keeps what it has.
template <class real>
PLIANT_INLINE Wide<real> rest_after(const Wide<real>& before, const Wide<real>& x, const Wide<real>& size,
                                    const Wide4<real>& stays) {
  const Wide<real> least = Wide<real>{} + real(0.05), most = Wide<real>{} + 20;
  const Wide<real> now = x * before, strain = (size - now) / now;
  const Wide<real> stretch = 1 + (stays.y * stays.x + stays.z * (strain - stays.x));
  const Wide<real> after = size / (x * (stretch > least ? stretch : least));
  const Wide<real> bounded = after > least ? after < most ? after : most : least;
  const auto keeps = (x <= 0) | ((stays.y >= 1) & (stays.z >= 1));
  return keeps ? before : bounded;
}

} // namespace

template <class real> void plastic_flow(const kernels::plastic_flow::View<real>& k) {
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint s = 0; s < slice_count(k.threads); ++s)
    for_each_part(k, s, [&](const Part<real>& part, uint local) {
      const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
      const Wide4<real> own = gather<2>(k.flow + 1, part.index);
      const uint slice = k.first_slice + local / 16, lane = local % 16;
      const Wide<real> none{}, one = none + 1;
      Wide<real> stiffness{}, changed{};
      for (std::size_t row = k.slice_begin[slice], end = k.slice_begin[slice + 1]; row < end; ++row) {
        const std::size_t entry = 32 * row + lane;
        const uint* const j = k.bond + entry;
        const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
        const Wide3<real> xi = unpack_bonds<real>(load_words<real>(j + 16));
        const Wide3<real> y{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                            (yj.z - yi.z) + (uj.z - ui.z)};
        const Wide<real> x = unit * root_wide<real>(dot(xi, xi)), size = root_wide<real>(dot(y, y));
        const Wide4<real> other = gather<2>(k.flow + 1, j);
        const Wide<real> before_out = load_wide(k.rest + entry), before_in = load_wide(k.rest + entry + 16);
        const Wide<real> p_out = rest_after<real>(before_out, x, size, own),
                         p_in = rest_after<real>(before_in, x, size, other);
        const Wide<real> share = own.w * load_wide(k.weight + entry) / (p_out * p_out) +
                                 other.w * load_wide(k.weight + entry + 16) / (p_in * p_in);
        stiffness += x > 0 ? share : none;
        const auto differs = (p_out != before_out) | (p_in != before_in);
        if (bits<real>(differs) == 0) continue;
        changed = differs ? one : changed;
        store_reals(k.rest + entry, lanes<real>, p_out);
        store_reals(k.rest + entry + 16, lanes<real>, p_in);
      }
      for (uint at = 0; at < part.count; ++at)
        if (changed[at] > 0) k.linear_start[part.first + at].w = stiffness[at];
    });
}

PLIANT_BODY(plastic_flow)

} // namespace pliant::openmp::PLIANT_ISA
