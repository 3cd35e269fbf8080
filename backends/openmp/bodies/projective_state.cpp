// Local step of law M1; see kernels/projective_state.decl.
#include "kernels/projective_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void projective_state(const kernels::projective_state::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> yi = xyz(k.position[i]), ui = xyz(k.displacement[i]);
    Mat3<real> yx = zero_matrix<real>();
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      const Vec3<real> y = (xyz(k.position[j]) - yi) + (xyz(k.displacement[j]) - ui);
      add_outer(yx, c_out * dot(xi, xi), y, xi);
    });
    real row[6];
    for (uint r = 0; r < 6; ++r) row[r] = k.shape[std::size_t{r + 2} * k.stride + i];
    Mat3<real> f =
        yx * Mat3<real>{{{row[0], row[1], row[2]}, {row[1], row[3], row[4]}, {row[2], row[4], row[5]}}};
    if (k.swap_rows) {
      if (determinant(f) < 0) {
        for (int c = 0; c < 3; ++c) {
          const real first = f.m[0][c];
          f.m[0][c] = f.m[1][c];
          f.m[1][c] = first;
        }
      }
    } else {
      f = clamp_singular_values(f, real(0.1));
    }
    k.record[3 * i] = {f.m[0][0], f.m[0][1], f.m[0][2], ui.x};
    k.record[3 * i + 1] = {f.m[1][0], f.m[1][1], f.m[1][2], ui.y};
    k.record[3 * i + 2] = {f.m[2][0], f.m[2][1], f.m[2][2], ui.z};
  }
}

PLIANT_BODY(projective_state)

} // namespace pliant::openmp::PLIANT_ISA
