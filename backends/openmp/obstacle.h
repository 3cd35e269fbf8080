// Signed distances of obstacles in their own axes.
#pragma once

#include "backends/openmp/math.h"
#include "shaders/common/contact.glsl"

namespace pliant::openmp::PLIANT_ISA {

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

/// Of a kind other than meshes.
template <class real>
PLIANT_INLINE Reach<real> shape_distance(int kind, const Place<real>& p, Vec3<real> size) {
  switch (kind) {
  case OBSTACLE_SPHERE:
    return sphere_distance(p, size.x);
  case OBSTACLE_BOX:
    return box_distance(p, size);
  case OBSTACLE_CYLINDER:
    return cylinder_distance(p, size.x, size.y);
  case OBSTACLE_TORUS:
    return torus_distance(p, size.x, size.y);
  default:
    return {p.now.y, {0, 1, 0}};
  }
}

} // namespace pliant::openmp::PLIANT_ISA
