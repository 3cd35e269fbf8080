// See kernels/correspondence_tangent.decl.
#include "kernels/correspondence_tangent.h"
#include "backends/openmp/body.h"
#include "backends/openmp/slice.h"
#include "backends/openmp/symmetric.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// By how much the derivative of the stress lacks being positive, in mu.
template <class real> real lacking(const Mat3<real>& u, real stiffness, real pressure) {
  Mat3<real> even;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) even.m[r][c] = (u.m[r][c] + u.m[c][r]) / 2;
  const Vec3<real> sigma = symmetric_values(even);
  const real g[3] = {sigma.y * sigma.z, sigma.x * sigma.z, sigma.x * sigma.y};
  const real off[3][3] = {{0, sigma.z, sigma.y}, {sigma.z, 0, sigma.x}, {sigma.y, sigma.x, 0}};
  Mat3<real> block;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      block.m[r][c] = (r == c ? real(1) : real(0)) + stiffness * g[r] * g[c] + pressure * off[r][c];
  const Vec3<real> values = symmetric_values(block);
  const real longest = larger(magnitude(sigma.x), larger(magnitude(sigma.y), magnitude(sigma.z)));
  const real twist = 1 - magnitude(pressure) * longest;
  const real least = smaller(twist, smaller(values.x, smaller(values.y, values.z)));
  return larger(real(0), -least);
}

} // namespace

template <class real> void correspondence_tangent(const kernels::correspondence_tangent::View<real>& k) {
  if (k.solver[SOLVER_TAKEN] == 0 || k.solver[SOLVER_LINEAR] == 0) return;
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint i = k.first + local;
    const Vec3<real> ui = xyz(k.displacement[i]);
    Mat3<real> s;
    for (std::size_t e = 0; e < 9; ++e) s.m[e / 3][e % 3] = k.shape[(e + 2) * k.stride + i];
    for_each_bond(k, local, [&](uint j, Vec3<real> xi, real c_out, real) {
      add_outer(s, c_out, xyz(k.displacement[j]) - ui, xi);
    });
    const Mat3<real> f = scaled(k.shape[i], s) * symmetric_rows(k.shape, 11, k.stride, i);
    const real stiffness = 1 + k.shape[k.stride + i] / real(1.5); // lambda / mu
    const real pressure = stiffness * (determinant(f) - 1) - 1;
    real raise = 0;
    if (k.solver[SOLVER_CONVEX] > 0)
      raise = lacking(transposed_product(rotation_matrix(k.rotation[i]), f), stiffness, pressure);
    store_rows(k.tangent + 4 * std::size_t{i}, f, pressure, raise, real(0));
  }
}

PLIANT_BODY(correspondence_tangent)

} // namespace pliant::openmp::PLIANT_ISA
