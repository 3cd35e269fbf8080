// See kernels/newton_product.decl.
#include "kernels/newton_product.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void newton_product(const kernels::newton_product::View<real>& k) {
  if (k.solver[SOLVER_LINEAR] == 0) return;
  constexpr uint group = kernels::newton_product::group_size;
#pragma omp parallel for schedule(static)
  for (uint block = 0; block < (k.threads + group - 1) / group; ++block) {
    real sum = 0;
    for (uint i = group * block; i < smaller(group * (block + 1), k.threads); ++i) {
      const Vec3<real> p = xyz(k.direction[i]);
      const auto f = k.force[i];
      const real inertia = k.inertia_target[i].w;
      Vec3<real> q{0, 0, 0};
      if (inertia >= 0) {
        q = inertia * p - xyz(f);
        if (k.obstacles) {
          const auto a = k.contact_block[2 * std::size_t{i}], b = k.contact_block[2 * std::size_t{i} + 1];
          q.x += a.x * p.x + a.y * p.y + a.z * p.z;
          q.y += a.y * p.x + a.w * p.y + b.x * p.z;
          q.z += a.z * p.x + b.x * p.y + b.y * p.z;
        }
      }
      k.force[i] = {q.x, q.y, q.z, f.w};
      sum += dot(p, q);
    }
    k.solve_partial[block] = {sum, 0, 0, 0};
  }
}

PLIANT_BODY(newton_product)

} // namespace pliant::openmp::PLIANT_ISA
