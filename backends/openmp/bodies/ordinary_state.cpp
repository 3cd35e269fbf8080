// Local step of law M2; see kernels/ordinary_state.decl.
#include "kernels/ordinary_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/rest.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void ordinary_state(const kernels::ordinary_state::View<real>& k) {
  if ((k.plastic ? k.gate[0].x : k.solver[SOLVER_STOP]) > 0) return;
  const real unit = grid_unit(k.unit);
  with_rest(k, [&](auto plastic) {
#pragma omp parallel for schedule(static)
    for (uint s = 0; s < slice_count(k.threads); ++s)
      for_each_part(k, s, [&](const Part<real>& part, uint local) {
        const Wide4<real> yi = gather(k.position, part.index), ui = gather(k.displacement, part.index);
        Wide<real> lengthening{}; // sum c x (y - x): the dilatation less one, without its cancellation
        for_each_bond_at_rest_of_part<plastic()>(
            k, local, [&](const uint* j, const Wide3<real>& xi, const WideRestBond<real>& at_rest) {
              const Wide4<real> yj = gather(k.position, j), uj = gather(k.displacement, j);
              const Wide3<real> y{(yj.x - yi.x) + (uj.x - ui.x), (yj.y - yi.y) + (uj.y - ui.y),
                                  (yj.z - yi.z) + (uj.z - ui.z)};
              const Wide<real> x = unit * root_wide<real>(dot(xi, xi)) * at_rest.p_out;
              lengthening += at_rest.c_out * x * (root_wide<real>(dot(y, y)) - x);
            });
        const uint i = part.first;
        const Wide<real> phi = load_wide(k.shape + k.stride + i) * load_wide(k.shape + i) * lengthening;
        store(k.extension + i, part.count, Wide4<real>{ui.x, ui.y, ui.z, phi});
      });
  });
}

PLIANT_BODY(ordinary_state)

} // namespace pliant::openmp::PLIANT_ISA
