// One row for the step; see kernels/statistics_total.decl.
#include "kernels/statistics_total.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void statistics_total(const kernels::statistics_total::View<real>& k) {
  real kinetic = 0, elastic = 0, speed2 = 0, shift2 = 0, wrong = 0;
  Vec3<real> momentum{0, 0, 0};
  for (uint chunk = 0; chunk < k.chunk_count; ++chunk) {
    const auto energies = k.chunk_sum[2 * chunk], moment = k.chunk_sum[2 * chunk + 1];
    kinetic += energies.x;
    elastic += energies.y;
    speed2 = larger(speed2, energies.z);
    wrong += energies.w;
    momentum = momentum + xyz(moment);
    shift2 = larger(shift2, moment.w);
  }
  real* const row = k.statistics + std::size_t{16} * k.row;
  row[0] = kinetic;
  row[1] = elastic;
  row[2] = root(speed2);
  row[3] = wrong;
  row[4] = momentum.x;
  row[5] = momentum.y;
  row[6] = momentum.z;
  row[7] = root(shift2);
  row[8] = k.solver[SOLVER_FIRST];
  row[9] = k.solver[SOLVER_BEST];
  row[10] = k.solver[SOLVER_FLOOR];
  row[11] = k.solver[SOLVER_ITERATIONS];
  row[12] = k.solver[SOLVER_RESTARTS];
  row[13] = k.solver[SOLVER_REASON];
  row[14] = k.solver[SOLVER_ONE_MINUS_RHO];
  row[15] = k.solver[SOLVER_GAMMA];
}

PLIANT_BODY(statistics_total)

} // namespace pliant::openmp::PLIANT_ISA
