// The rigid motion that takes the rest of momentum out; see kernels/component_motion.decl.
#include "kernels/component_motion.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void component_motion(const kernels::component_motion::View<real>& k) {
  for (uint c = 0; c < k.threads; ++c) {
    Vec3<real> sum[5] = {};
    real m = 0, held = 0;
    for (uint chunk = k.component[c].x; chunk < k.component[c].y; ++chunk) {
      for (uint row = 0; row < 5; ++row) sum[row] = sum[row] + xyz(k.moment[5 * chunk + row]);
      m += k.moment[5 * chunk].w;
      held += k.moment[5 * chunk + 1].w;
    }
    for (uint row = 0; row < 3; ++row) k.rigid[3 * c + row] = {0, 0, 0, 0};
    if (held > 0 || !(m > 0)) continue; // something else holds it: its momentum is not its own
    const Vec3<real> mean = (1 / m) * sum[0], y = (1 / m) * sum[1];
    k.rigid[3 * c] = {-mean.x, -mean.y, -mean.z, 0};
    k.rigid[3 * c + 2] = {y.x, y.y, y.z, 0};
    if (!k.component[c].z) continue;
    // About the centre: L = sum m (y - c) x d, I = sum m (|y - c|^2 - (y - c)(y - c)^T), solved by cofactors.
    const Vec3<real> l = sum[2] - m * cross(y, mean);
    const Vec3<real> s = sum[3] - m * Vec3<real>{y.x * y.x, y.y * y.y, y.z * y.z};
    const Vec3<real> t = sum[4] - m * Vec3<real>{y.x * y.y, y.x * y.z, y.y * y.z};
    const real trace = s.x + s.y + s.z, round_off = sizeof(real) == 8 ? real(1e-14) : real(1e-5);
    // A single particle has nothing to turn: what is left of its trace is noise.
    if (!(trace > (sizeof(real) == 8 ? real(1e-14) : real(1e-6)) * (sum[3].x + sum[3].y + sum[3].z)))
      continue;
    const real ixx = (s.y + s.z) / trace + round_off, iyy = (s.x + s.z) / trace + round_off,
               izz = (s.x + s.y) / trace + round_off;
    const real ixy = -t.x / trace, ixz = -t.y / trace, iyz = -t.z / trace;
    const Vec3<real> row0{iyy * izz - iyz * iyz, ixz * iyz - ixy * izz, ixy * iyz - ixz * iyy};
    const Vec3<real> row1{row0.y, ixx * izz - ixz * ixz, ixy * ixz - ixx * iyz};
    const Vec3<real> row2{row0.z, row1.z, ixx * iyy - ixy * ixy};
    const real det = ixx * row0.x + ixy * row0.y + ixz * row0.z;
    const Vec3<real> b = (-1 / (trace * det)) * l;
    k.rigid[3 * c + 1] = {dot(row0, b), dot(row1, b), dot(row2, b), 0};
  }
}

PLIANT_BODY(component_motion)

} // namespace pliant::openmp::PLIANT_ISA
