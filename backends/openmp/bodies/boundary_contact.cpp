// Obstacles; see kernels/boundary_contact.decl.
#include "kernels/boundary_contact.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/contact.glsl"
#include "shaders/common/solver.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// Signed distance, m, and its gradient in the obstacle's own axes, pointing outwards.
template <class real> struct Reach {
  real d;
  Vec3<real> normal;
};

// A place in an obstacle's own axes, split in where the step began and the displacement since: sums are
// formed so that rounding of the large part is the same for every iterate.
template <class real> struct Place { Vec3<real> a, u, now; };

// sqrt(b) - sqrt(a) for b - a known exactly as `change`, from both roots.
template <class real> PLIANT_INLINE real root_change(real root_a, real root_b, real change) {
  return root_a + root_b > 0 ? change / (root_a + root_b) : real(0);
}

template <class real> PLIANT_INLINE real sign_of(real x) {
  return x < 0 ? real(-1) : real(1);
}

template <class real> PLIANT_INLINE Reach<real> sphere_distance(const Place<real>& p, real size) {
  const real before = norm(p.a), after = norm(p.now);
  const real d = (before - size) + root_change(before, after, dot(p.a + p.now, p.u));
  if (!(after > 0)) return {d, {0, 1, 0}};
  return {d, (1 / after) * p.now};
}

// A corner, edge or face by how far each coordinate lies beyond its half size.
template <class real> PLIANT_INLINE Reach<real> box_distance(const Place<real>& p, Vec3<real> half_size) {
  const Vec3<real> side{sign_of(p.now.x), sign_of(p.now.y), sign_of(p.now.z)};
  const real qx = (side.x * p.a.x - half_size.x) + side.x * p.u.x;
  const real qy = (side.y * p.a.y - half_size.y) + side.y * p.u.y;
  const real qz = (side.z * p.a.z - half_size.z) + side.z * p.u.z;
  const real most = larger(qx, larger(qy, qz));
  if (most > 0) {
    const Vec3<real> out{larger(qx, real(0)), larger(qy, real(0)), larger(qz, real(0))};
    const real d = norm(out);
    return {d, (1 / d) * Vec3<real>{side.x * out.x, side.y * out.y, side.z * out.z}};
  }
  if (qx == most) return {most, {side.x, 0, 0}};
  if (qy == most) return {most, {0, side.y, 0}};
  return {most, {0, 0, side.z}};
}

// Distance from the y axis: at the start, its change, and the direction outwards.
template <class real> struct Radial {
  real start, change;
  Vec3<real> outward;
};
template <class real> PLIANT_INLINE Radial<real> radial(const Place<real>& p) {
  const real before = root(p.a.x * p.a.x + p.a.z * p.a.z);
  const real after = root(p.now.x * p.now.x + p.now.z * p.now.z);
  const real change = root_change(before, after, (p.a.x + p.now.x) * p.u.x + (p.a.z + p.now.z) * p.u.z);
  if (!(after > 0)) return {before, change, {1, 0, 0}};
  return {before, change, {p.now.x / after, 0, p.now.z / after}};
}

template <class real>
PLIANT_INLINE Reach<real> cylinder_distance(const Place<real>& p, real size, real half_height) {
  const Radial<real> r = radial(p);
  const real side = sign_of(p.now.y);
  const real q = (r.start - size) + r.change, h = (side * p.a.y - half_height) + side * p.u.y;
  if (q <= 0 && h <= 0) {
    if (q >= h) return {q, r.outward};
    return {h, {0, side, 0}};
  }
  const real q_out = larger(q, real(0)), h_out = larger(h, real(0)), d = root(q_out * q_out + h_out * h_out);
  return {d, {q_out / d * r.outward.x, h_out / d * side, q_out / d * r.outward.z}};
}

template <class real> PLIANT_INLINE Reach<real> torus_distance(const Place<real>& p, real ring, real tube) {
  const Radial<real> r = radial(p);
  const real before = r.start - ring, after = before + r.change;
  const real root_before = root(before * before + p.a.y * p.a.y);
  const real root_after = root(after * after + p.now.y * p.now.y);
  const real change = (before + after) * r.change + (p.a.y + p.now.y) * p.u.y;
  const real d = (root_before - tube) + root_change(root_before, root_after, change);
  if (!(root_after > 0)) return {d, {0, 1, 0}};
  return {d, (1 / root_after) * (after * r.outward + Vec3<real>{0, p.now.y, 0})};
}

// The largest whole number not above x, for |x| < 1e6; what is not finite is far as well.
template <class real> PLIANT_INLINE real whole_below(real x) {
  const real bounded = larger(smaller(x, real(1e6)), real(-1e6));
  const real cut = static_cast<real>(static_cast<int>(bounded));
  return cut > bounded ? cut - 1 : cut;
}

// One axis of a grid: the cell, and where in it (0 to 1); `beyond` is how far outside the grid, in cells.
template <class real> struct Axis {
  uint cell;
  real part, beyond;
};
template <class real> PLIANT_INLINE Axis<real> grid_axis(real a, real u, real low, real cell, uint nodes) {
  const real last = static_cast<real>(nodes - 2), s = (a - low) / cell;
  // Cells are counted from the one where the step began, so that u keeps its digits.
  const real whole = whole_below(s), moved = (s - whole) + u / cell;
  const real at = larger(real(0), smaller(last, whole + whole_below(moved)));
  const real part = moved - (at - whole);
  const real within = larger(real(0), smaller(real(1), part));
  return {static_cast<uint>(at), within, part - within};
}

template <class real>
PLIANT_INLINE Reach<real> mesh_distance(const Place<real>& p, Vec3<real> low, real cell, const Uint4& nodes,
                                        const real* __restrict values, bool container) {
  const Axis<real> x = grid_axis(p.a.x, p.u.x, low.x, cell, nodes.x),
                   y = grid_axis(p.a.y, p.u.y, low.y, cell, nodes.y),
                   z = grid_axis(p.a.z, p.u.z, low.z, cell, nodes.z);
  const Vec3<real> beyond = cell * Vec3<real>{x.beyond, y.beyond, z.beyond};
  const real away = norm(beyond);
  if (!(away < real(1e18)) || (away > 0 && !container)) return {real(1e18), {0, 0, 0}};
  const real* corner = values + nodes.w + (std::size_t{z.cell} * nodes.y + y.cell) * nodes.x + x.cell;
  real value = 0;
  Vec3<real> slope{0, 0, 0};
  for (uint c = 0; c < 8; ++c) {
    const uint cx = c & 1, cy = (c >> 1) & 1, cz = c >> 2;
    const real v = corner[(std::size_t{cz} * nodes.y + cy) * nodes.x + cx];
    const real wx = cx ? x.part : 1 - x.part, wy = cy ? y.part : 1 - y.part, wz = cz ? z.part : 1 - z.part;
    value += wx * wy * wz * v;
    slope.x += (cx ? v : -v) * wy * wz;
    slope.y += (cy ? v : -v) * wx * wz;
    slope.z += (cz ? v : -v) * wx * wy;
  }
  if (away > 0) return {value + away, (1 / away) * beyond};
  return {value, (1 / cell) * slope};
}

} // namespace

template <class real> void boundary_contact(const kernels::boundary_contact::View<real>& k) {
  if (k.solver[SOLVER_STOP] > 0) return;
  const Vec3<real> base{k.base_x, k.base_y, k.base_z};
#pragma omp parallel for schedule(static)
  for (uint i = 0; i < k.threads; ++i) {
    auto f = k.force[i];
    const Vec3<real> u = xyz(k.displacement[i]);
    Vec3<real> begin; // y_n relative to the base
    real stiffness;
    if (k.potential || k.tangent) {
      begin = xyz(k.start[i]);
      stiffness = k.start[i].w;
    } else {
      begin = (xyz(k.origin[k.owner[i]]) - base) + xyz(k.position[i]);
      stiffness = f.w > 0 ? f.w : k.least_stiffness;
    }
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
      Reach<real> reach;
      switch (static_cast<int>(traits.x)) {
      case OBSTACLE_PLANE:
        reach = {p.now.y, {0, 1, 0}};
        break;
      case OBSTACLE_SPHERE:
        reach = sphere_distance(p, size.x);
        break;
      case OBSTACLE_BOX:
        reach = box_distance(p, xyz(size));
        break;
      case OBSTACLE_CYLINDER:
        reach = cylinder_distance(p, size.x, size.y);
        break;
      case OBSTACLE_TORUS:
        reach = torus_distance(p, size.x, size.y);
        break;
      default:
        if (!k.meshes) continue;
        reach = mesh_distance(p, Vec3<real>{axes[0].w, axes[1].w, axes[2].w}, size.w, k.grid[o],
                              k.grid_distance, container);
      }
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
}

PLIANT_BODY(boundary_contact)

} // namespace pliant::openmp::PLIANT_ISA
