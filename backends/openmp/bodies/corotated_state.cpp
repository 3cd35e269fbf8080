// Local step of law M4; see kernels/corotated_state.decl.
#include "kernels/corotated_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void corotated_state(const kernels::corotated_state::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> ui = xyz(k.displacement[i]);
    Mat3<real> s;
    for (uint r = 0; r < 3; ++r)
      for (uint c = 0; c < 3; ++c) s.m[r][c] = k.shape[std::size_t{3 * r + c + 2} * k.stride + i];
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      add_outer(s, c_out, xyz(k.displacement[j]) - ui, xi);
    });
    const real inverse_modulus = k.shape[i];
    for (auto& row : s.m)
      for (real& value : row) value *= inverse_modulus;
    const Real4<real> q = polar_rotation(s, k.rotation[i]);
    const Mat3<real> r = rotation_matrix(q);
    const real theta = inner(r, s);
    const real scale = 1 - k.shape[k.stride + i] * (theta - 1);
    k.rotation[i] = q;
    k.record[3 * i] = {scale * r.m[0][0], scale * r.m[0][1], scale * r.m[0][2], ui.x};
    k.record[3 * i + 1] = {scale * r.m[1][0], scale * r.m[1][1], scale * r.m[1][2], ui.y};
    k.record[3 * i + 2] = {scale * r.m[2][0], scale * r.m[2][1], scale * r.m[2][2], ui.z};
  }
}

PLIANT_BODY(corotated_state)

} // namespace pliant::openmp::PLIANT_ISA
