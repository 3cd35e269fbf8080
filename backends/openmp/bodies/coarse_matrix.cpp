// See kernels/coarse_matrix.decl.
#include "kernels/coarse_matrix.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <class real> PLIANT_INLINE Mat3<real> cell_turn(const Real4<real>& q) {
  const real size2 = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  const real s = 1 / root(larger(size2, real(1e-30)));
  return rotation_matrix(Real4<real>{s * q.x, s * q.y, s * q.z, s * q.w});
}

// The adjugate over the determinant; zero where there is nothing to invert.
template <class real> PLIANT_INLINE void invert(const real* k, real* inverse) {
  const real c0 = k[4] * k[8] - k[5] * k[7], c1 = k[5] * k[6] - k[3] * k[8], c2 = k[3] * k[7] - k[4] * k[6];
  const real det = k[0] * c0 + k[1] * c1 + k[2] * c2, f = det > 0 ? 1 / det : 0;
  inverse[0] = f * c0, inverse[1] = f * (k[2] * k[7] - k[1] * k[8]),
  inverse[2] = f * (k[1] * k[5] - k[2] * k[4]);
  inverse[3] = f * c1, inverse[4] = f * (k[0] * k[8] - k[2] * k[6]),
  inverse[5] = f * (k[2] * k[3] - k[0] * k[5]);
  inverse[6] = f * c2, inverse[7] = f * (k[1] * k[6] - k[0] * k[7]),
  inverse[8] = f * (k[0] * k[4] - k[1] * k[3]);
}

} // namespace

template <class real> void coarse_matrix(const kernels::coarse_matrix::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static) if (k.threads > 64)
  for (uint local = 0; local < k.threads; ++local) {
    const uint n = k.first_node + local, slice = n / 16, lane = n % 16;
    real blocks[27][9] = {};
    for (uint c = 0; c < 8; ++c) {
      const uint at = k.cell[(slice * 8 + c) * 16 + lane];
      if (at == 0xffffffffu) continue;
      const real* table = k.stiffness + (std::size_t{k.signature[at]} * 64 + 8 * (7 - c)) * 12;
      Mat3<real> r{};
      if (k.rotated) r = cell_turn(k.cell_rotation[at]);
      for (uint b = 0; b < 8; ++b, table += 12) {
        real* const block =
            blocks[(c & 1) + (b & 1) + 3 * ((c >> 1 & 1) + (b >> 1 & 1)) + 9 * ((c >> 2) + (b >> 2))];
        const real trace = table[0] + table[4] + table[8], ratio = table[10];
        real diagonal = trace + k.per_step2 * table[9];
        if (k.rotated) {
          real half[3][3], turned[3][3]; // R M, R M R^T
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
              half[i][j] = r.m[i][0] * table[j] + r.m[i][1] * table[3 + j] + r.m[i][2] * table[6 + j];
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
              turned[i][j] = half[i][0] * r.m[j][0] + half[i][1] * r.m[j][1] + half[i][2] * r.m[j][2];
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) block[3 * i + j] += turned[j][i] + ratio * turned[i][j];
        } else {
          diagonal += (1 + ratio) * trace;
        }
        block[0] += diagonal, block[4] += diagonal, block[8] += diagonal;
      }
    }
    if (k.obstacles) {
      const auto d = k.coarse_block[2 * std::size_t{n}], e = k.coarse_block[2 * std::size_t{n} + 1];
      const real six[9] = {d.x, d.y, d.z, d.y, d.w, e.x, d.z, e.x, e.y};
      for (int i = 0; i < 9; ++i) blocks[13][i] += six[i];
    }
    real inverse[9];
    invert(blocks[13], inverse);
    real* const matrix = k.matrix + std::size_t{slice} * 27 * 144 + lane;
    for (std::size_t b = 0; b < 27; ++b)
      for (std::size_t i = 0; i < 9; ++i) matrix[(9 * b + i) * 16] = blocks[b][i];
    for (std::size_t i = 0; i < 9; ++i)
      k.inverse_block[(std::size_t{slice} * 9 + i) * 16 + lane] = inverse[i];
  }
}

PLIANT_BODY(coarse_matrix)

} // namespace pliant::openmp::PLIANT_ISA
