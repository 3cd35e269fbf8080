// Contacts on both sides or on neither; see kernels/contact_mutual.decl.
#include "kernels/contact_mutual.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/contact.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void contact_mutual(const kernels::contact_mutual::View<real>& k) {
  if (k.left_out[0] == 0) return;
  const auto list = [&](uint i) { return k.contact + std::size_t{CONTACTS * 16} * (i / 16) + i % 16; };
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    uint* mine = list(i);
    for (uint a = 0; a < CONTACTS && mine[16 * a] != i; ++a) {
      const uint j = mine[16 * a];
      const uint* theirs = list(j);
      bool mutual = false;
      for (uint b = 0; b < CONTACTS && !mutual; ++b) {
        // Others may be setting the mark of this entry: it does not matter here.
        const uint back = __atomic_load_n(&theirs[16 * b], __ATOMIC_RELAXED) & ~CONTACT_DROPPED;
        if (back == j) break;
        mutual = back == i;
      }
      if (!mutual) __atomic_store_n(&mine[16 * a], j | CONTACT_DROPPED, __ATOMIC_RELAXED);
    }
  }
}

PLIANT_BODY(contact_mutual)

} // namespace pliant::openmp::PLIANT_ISA
