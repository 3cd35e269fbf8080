// Local step of law M4; see kernels/corotated_state.decl.
#include "kernels/corotated_state.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd_rotation.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// Lanes that Newton's method gave up: one by one, from the start that they had.
template <class real>
[[gnu::noinline]] void rotate_rest(uint failed, const WideMat3<real>& s, const Wide4<real>& start,
                                   Wide4<real>& q) {
  for (uint lane = 0; lane < lanes<real>; ++lane) {
    if (!(failed >> lane & 1)) continue;
    Mat3<real> own;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) own.m[r][c] = s.m[r][c][lane];
    const Real4<real> found =
        polar_rotation(own, {start.x[lane], start.y[lane], start.z[lane], start.w[lane]});
    q.x[lane] = found.x, q.y[lane] = found.y, q.z[lane] = found.z, q.w[lane] = found.w;
  }
}

} // namespace

template <class real> void corotated_state(const kernels::corotated_state::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
  const real unit = grid_unit(k.unit);
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < slice_count(k.threads); ++slice)
    for_each_part(k, slice, [&](const Part<real>& part, uint local) {
      const uint i = part.first;
      const Wide4<real> ui = gather(k.displacement, part.index);
      WideMat3<real> s{};
      for_each_bond_of_part(k, local, [&](const uint* j, Wide3<real> xi, Wide<real> c_out, Wide<real>) {
        const Wide4<real> uj = gather(k.displacement, j);
        const Wide<real> x = c_out * (uj.x - ui.x), y = c_out * (uj.y - ui.y), z = c_out * (uj.z - ui.z);
        s.m[0][0] += x * xi.x, s.m[0][1] += x * xi.y, s.m[0][2] += x * xi.z;
        s.m[1][0] += y * xi.x, s.m[1][1] += y * xi.y, s.m[1][2] += y * xi.z;
        s.m[2][0] += z * xi.x, s.m[2][1] += z * xi.y, s.m[2][2] += z * xi.z;
      });
      const Wide<real> inverse_modulus = load_wide(k.shape + i);
      for (uint r = 0; r < 3; ++r)
        for (uint c = 0; c < 3; ++c)
          s.m[r][c] = inverse_modulus *
                      (unit * s.m[r][c] + load_wide(k.shape + std::size_t{3 * r + c + 2} * k.stride + i));
      const Wide4<real> start = gather(k.rotation, part.index);
      Wide4<real> q = start;
      const uint failed = polar_rotation(s, q) & ((2u << (part.count - 1)) - 1);
      if (failed) rotate_rest(failed, s, start, q);
      const WideMat3<real> r = rotation_matrix<real>(q);
      Wide<real> theta{};
      for (uint row = 0; row < 3; ++row)
        for (uint column = 0; column < 3; ++column) theta += r.m[row][column] * s.m[row][column];
      const Wide<real> scale = 1 - load_wide(k.shape + k.stride + i) * (theta - 1);
      store(k.rotation + i, part.count, q);
      const Wide<real> u[3] = {ui.x, ui.y, ui.z};
      for (uint row = 0; row < 3; ++row)
        store<3>(k.record + 3 * std::size_t{i} + row, part.count,
                 Wide4<real>{scale * r.m[row][0], scale * r.m[row][1], scale * r.m[row][2], u[row]});
    });
}

PLIANT_BODY(corotated_state)

} // namespace pliant::openmp::PLIANT_ISA
