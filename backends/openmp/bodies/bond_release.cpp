// Energy of broken bonds; see kernels/bond_release.decl.
#include "kernels/bond_release.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void bond_release(const kernels::bond_release::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) k.released[i] += k.before[i] - k.energy[i];
}

PLIANT_BODY(bond_release)

} // namespace pliant::openmp::PLIANT_ISA
