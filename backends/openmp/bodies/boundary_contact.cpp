// Obstacles; see kernels/boundary_contact.decl.
#include "kernels/boundary_contact.h"
#include "backends/openmp/body.h"
#include "backends/openmp/obstacle.h"
#include "backends/openmp/obstacle_wide.h"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// y_n relative to the base; w: stiffness of its contacts.
template <class real>
PLIANT_INLINE Real4<real> start_of(const kernels::boundary_contact::View<real>& k, uint i) {
  if (k.potential || k.tangent) return k.start[i];
  const Vec3<real> begin =
      (xyz(k.origin[k.owner[i]]) - Vec3<real>{k.base_x, k.base_y, k.base_z}) + xyz(k.position[i]);
  const real stiffness = k.force[i].w;
  return {begin.x, begin.y, begin.z, stiffness > 0 ? stiffness : k.least_stiffness};
}

template <class real> void touch(const kernels::boundary_contact::View<real>& k, uint i) {
  const Vec3<real> base{k.base_x, k.base_y, k.base_z};
  auto f = k.force[i];
  const Vec3<real> u = xyz(k.displacement[i]);
  const Real4<real> own = start_of(k, i);
  const Vec3<real> begin = xyz(own);
  const real stiffness = own.w;
  uint acts = 0;
  real stored = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (uint o = 0; o < k.obstacles; ++o) {
    const auto* rows = k.obstacle + OBSTACLE_ROWS * o;
    const auto traits = rows[OBSTACLE_KIND], place = rows[OBSTACLE_CENTRE];
    const Vec3<real> start = begin - (xyz(place) - base), now = start + u;
    if (dot(now, now) > place.w * place.w) continue;
    const auto size = rows[OBSTACLE_SIZE];
    const auto *axes = rows + OBSTACLE_AXES, *shift = rows + OBSTACLE_SHIFT;
    const Mat3<real> r{{{axes[0].x, axes[0].y, axes[0].z},
                        {axes[1].x, axes[1].y, axes[1].z},
                        {axes[2].x, axes[2].y, axes[2].z}}};
    Place<real> p;
    p.a = start.x * xyz(axes[0]) + start.y * xyz(axes[1]) + start.z * xyz(axes[2]); // R^T start
    p.u = u.x * xyz(axes[0]) + u.y * xyz(axes[1]) + u.z * xyz(axes[2]);
    p.now = p.a + p.u;
    const bool container = traits.w > 0;
    const int kind = static_cast<int>(traits.x);
    if (kind == OBSTACLE_MESH && !k.meshes) continue;
    const Reach<real> reach = kind == OBSTACLE_MESH
                                  ? mesh_distance(p, Vec3<real>{axes[0].w, axes[1].w, axes[2].w}, size.w,
                                                  k.grid[o], k.grid_distance, container)
                                  : shape_distance(kind, p, xyz(size));
    const real sense = container ? real(-1) : real(1), depth = k.radius - sense * reach.d;
    if (!(depth > 0)) continue;
    const Vec3<real> gradient = sense * (r * reach.normal);
    const Vec3<real> push = (stiffness * depth) * gradient;
    const Vec3<real> carried{dot(xyz(shift[0]), now) + shift[0].w, dot(xyz(shift[1]), now) + shift[1].w,
                             dot(xyz(shift[2]), now) + shift[2].w};
    Vec3<real> slide = u - carried;
    const real steep2 = dot(gradient, gradient);
    if (steep2 > 0) slide = slide - (dot(gradient, slide) / steep2) * gradient;
    real hold = stiffness;
    if (traits.z == 0) {
      const real limit = traits.y * norm(push), slid = norm(slide);
      if (!(stiffness * slid < limit)) hold = slid > 0 ? limit / slid : 0; // without friction: none
    }
    f.x += push.x - hold * slide.x;
    f.y += push.y - hold * slide.y;
    f.z += push.z - hold * slide.z;
    f.w += stiffness;
    acts = 1;
    if (k.potential) {
      stored += stiffness / 2 * depth * depth;
      if (traits.z != 0) stored += stiffness / 2 * dot(slide, slide);
    }
    if (k.tangent) {
      // Along the gradient the penalty's stiffness, across it the friction's: hold (1 - n n) + k g g.
      const Vec3<real> g = gradient;
      const real across = stiffness - (steep2 > 0 ? hold / steep2 : 0);
      xx += hold + across * g.x * g.x, yy += hold + across * g.y * g.y, zz += hold + across * g.z * g.z;
      xy += across * g.x * g.y, xz += across * g.x * g.z, yz += across * g.y * g.z;
    }
  }
  k.force[i] = f;
  k.touched[i] = acts;
  if (k.potential && acts) k.energy[i] += stored;
  if (k.tangent) {
    k.contact_block[2 * std::size_t{i}] = {xx, xy, xz, yy};
    k.contact_block[2 * std::size_t{i} + 1] = {yz, zz, 0, 0};
  }
}

} // namespace

template <class real> void boundary_contact(const kernels::boundary_contact::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    // Particles that follow each other are near each other: most parts are far from everything.
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> u = gather(k.displacement, part.index);
    Wide3<real> now{};
    uint near = 0, moves = 0;
    for (uint lane = 0; lane < part.count; ++lane) moves |= uint{!(k.force[first + lane].w < 0)} << lane;
    for (uint lane = 0; moves && lane < lanes<real>; ++lane) {
      const Real4<real> own = start_of(k, part.index[lane]);
      now.x[lane] = own.x, now.y[lane] = own.y, now.z[lane] = own.z;
    }
    now = {now.x + u.x, now.y + u.y, now.z + u.z};
    for (uint o = 0; moves && o < k.obstacles; ++o) {
      const auto* const rows = k.obstacle + OBSTACLE_ROWS * o;
      const auto centre = rows[OBSTACLE_CENTRE];
      const Wide3<real> from{now.x - (centre.x - k.base_x), now.y - (centre.y - k.base_y),
                             now.z - (centre.z - k.base_z)};
      near |= bits<real>(may_touch(rows, from, k.radius));
    }
    near &= moves;
    for (uint lane = 0; lane < part.count; ++lane) {
      const uint i = first + lane;
      if (near >> lane & 1) {
        touch(k, i);
        continue;
      }
      k.touched[i] = 0;
      if (k.tangent)
        k.contact_block[2 * std::size_t{i}] = k.contact_block[2 * std::size_t{i} + 1] = {0, 0, 0, 0};
    }
  }
}

PLIANT_BODY(boundary_contact)

} // namespace pliant::openmp::PLIANT_ISA
