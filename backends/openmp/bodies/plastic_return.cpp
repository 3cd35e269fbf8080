// Yield and return of each particle; see kernels/plastic_return.decl.
#include "kernels/plastic_return.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void plastic_return(const kernels::plastic_return::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local, slice = k.first_slice + local / 16, lane = local % 16;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    const auto surface = k.yield[2 * std::size_t{i}], own = k.yield[2 * std::size_t{i} + 1];
    const auto so_far = k.flow[2 * std::size_t{i}];
    const real volume = own.x, inverse_modulus = own.y, a_over_b = own.z;
    // sum of c x0^2 f(e), over the bonds' e = y / x - 1
    const auto average = [&](auto f) {
      real sum = 0;
      for (uint row = k.slice_begin[slice]; row < k.slice_begin[slice + 1]; ++row) {
        const std::size_t entry = std::size_t{32} * row + lane;
        const uint j = k.bond[entry];
        if (j == i) continue;
        const Vec3<real> xi = unpack_bond(k.bond[entry + 16], k.unit);
        const real x = norm(xi) * k.rest[entry];
        const real size = norm((xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui));
        sum += k.weight[entry] * dot(xi, xi) * f((size - x) / x);
      }
      return inverse_modulus * sum;
    };
    const real isotropic = average([](real e) { return e; });
    const real square = average([&](real e) { return (e - isotropic) * (e - isotropic); });
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
}

PLIANT_BODY(plastic_return)

} // namespace pliant::openmp::PLIANT_ISA
