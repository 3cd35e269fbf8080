// See kernels/coarse_contact.decl.
#include "kernels/coarse_contact.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void coarse_contact(const kernels::coarse_contact::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
  const Real4<real>* const block = k.particles ? k.contact_block : k.coarse_block;
#pragma omp parallel for schedule(static) if (k.threads > 256)
  for (uint local = 0; local < k.threads; ++local) {
    const uint slice = k.first_slice + local / 16;
    Quad<real> a{}, b{};
    for (std::size_t row = k.gather_begin[slice]; row < k.gather_begin[slice + 1]; ++row) {
      const std::size_t entry = 16 * row + local % 16, from = 2 * std::size_t{k.gather[entry]};
      const real w = k.gather_weight[entry];
      a += w * load_quad(block[from]);
      b += w * load_quad(block[from + 1]);
    }
    const std::size_t n = 2 * std::size_t{k.first_node + local};
    store_quad(k.coarse_block[n], a);
    store_quad(k.coarse_block[n + 1], b);
  }
}

PLIANT_BODY(coarse_contact)

} // namespace pliant::openmp::PLIANT_ISA
