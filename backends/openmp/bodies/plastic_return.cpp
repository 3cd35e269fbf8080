// Yield and return of each particle; see kernels/plastic_return.decl.
#include "kernels/plastic_return.h"
#include "backends/openmp/body.h"
#include "backends/openmp/bond_wide.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// The return of particle i, whose bonds have the mean strain `isotropic` and the mean square `square` about
/// it.
template <class real>
PLIANT_INLINE void return_one(const kernels::plastic_return::View<real>& k, uint i, real isotropic,
                              real square) {
  const auto surface = k.yield[2 * std::size_t{i}], own = k.yield[2 * std::size_t{i} + 1];
  const auto so_far = k.flow[2 * std::size_t{i}];
  const real volume = own.x, inverse_modulus = own.y, a_over_b = own.z;
  const real spread = root(square), trial = surface.x * spread;
  const real strength = surface.z + surface.w * so_far.x, bears = strength - surface.y * isotropic;
  real alpha = 0, beta = 0, strain = 0, taken = 0;
  const bool flows = trial > bears;
  if (flows) {
    const real most = k.equivalent * spread; // equivalent plastic strain that leaves nothing deviatoric
    strain = (trial - bears) / (surface.x / k.equivalent + surface.w);
    if (strain < most) {
      beta = strain / most;
    } else {
      strain = most;
      beta = 1;
      const real pull = surface.y * isotropic, beyond = pull - (strength + surface.w * most);
      if (beyond > 0) alpha = smaller(beyond / pull, real(1));
    }
    const real deviatoric = beta * (1 - beta) * square; // what is left, times what flows
    const real volumetric = a_over_b * alpha * (1 - alpha) * isotropic * isotropic;
    taken = (deviatoric + volumetric) / inverse_modulus;
  }
  k.flow[2 * std::size_t{i}] = {so_far.x + strain, so_far.y + taken,
                                so_far.z + volume * k.dimension * alpha * isotropic, real(flows ? 1 : 0)};
  k.flow[2 * std::size_t{i} + 1] = {isotropic, 1 - alpha, 1 - beta, larger(a_over_b, real(1))};
}

} // namespace

template <class real> void plastic_return(const kernels::plastic_return::View<real>& k) {
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint s = 0; s < slice_count(k.threads); ++s)
    for_each_part(k, s, [&](const Part<real>& part, uint local) {
      const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
      const Wide<real> inverse_modulus = gather<2>(k.yield + 1, part.index).y, none{};
      const uint slice = k.first_slice + local / 16, lane = local % 16;
      // sum of c x0^2 f(e), over the bonds' e = y / x - 1; padding has no length
      const auto average = [&](auto f) {
        Wide<real> sum{};
        for (std::size_t row = k.slice_begin[slice], end = k.slice_begin[slice + 1]; row < end; ++row) {
          const std::size_t entry = 32 * row + lane;
          const Wide4<real> yj = gather(k.position, k.bond + entry),
                            uj = gather(k.displacement, k.bond + entry);
          const Wide3<real> xi = unpack_bonds<real>(load_words<real>(k.bond + entry + 16));
          const Wide3<real> y{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                              (yj.z - yi.z) + (uj.z - ui.z)};
          const Wide<real> first = unit * root_wide<real>(dot(xi, xi)), x = first * load_wide(k.rest + entry);
          const Wide<real> e = x > 0 ? (root_wide<real>(dot(y, y)) - x) / x : none;
          sum += load_wide(k.weight + entry) * first * first * f(e);
        }
        return inverse_modulus * sum;
      };
      const Wide<real> isotropic = average([](const Wide<real>& e) { return e; });
      const Wide<real> square =
          average([&](const Wide<real>& e) { return (e - isotropic) * (e - isotropic); });
      for (uint at = 0; at < part.count; ++at) return_one(k, part.first + at, isotropic[at], square[at]);
    });
}

PLIANT_BODY(plastic_return)

} // namespace pliant::openmp::PLIANT_ISA
