// Out of obstacles; see kernels/fluid_project.decl.
#include "kernels/fluid_project.h"
#include "backends/openmp/body.h"
#include "backends/openmp/obstacle.h"
#include "backends/openmp/obstacle_wide.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// The share of the cubic spline that lies beyond a plane at x supports, and its derivative: integrals of
/// 16 q (2 (1 - q)^3 - (1 - 2 q)^3), the plane's rings, over the parts where each term is.
template <class real> struct Beyond {
  real share, slope;
  PLIANT_INLINE explicit Beyond(real x) {
    const real a = larger(1 - x, real(0)), b = larger(1 - 2 * x, real(0));
    const real a4 = a * a * a * a, b4 = b * b * b * b;
    share = a4 * a * (real(1.6) - a * 16 / 15) - b4 * b * (real(0.1) - b / 15);
    slope = b4 * (1 - real(0.8) * b) - a4 * (8 - real(6.4) * a);
  }
};

/// How far an obstacle pushes a particle that began the step at `start` and has moved since; adds to `wall`.
template <class real>
PLIANT_INLINE Vec3<real> pushed(const kernels::fluid_project::View<real>& k, uint o, Vec3<real> start,
                                Vec3<real> moved, Real4<real>& wall) {
  constexpr Vec3<real> none{0, 0, 0};
  const auto* rows = k.obstacle + OBSTACLE_ROWS * o;
  const auto traits = rows[OBSTACLE_KIND], place = rows[OBSTACLE_CENTRE], size = rows[OBSTACLE_SIZE];
  const Vec3<real> began = start - xyz(place), from = began + moved;
  if (!(dot(from, from) <= place.w * place.w)) return none;
  const auto *axes = rows + OBSTACLE_AXES, *shift = rows + OBSTACLE_SHIFT;
  Place<real> p;
  p.a = began.x * xyz(axes[0]) + began.y * xyz(axes[1]) + began.z * xyz(axes[2]); // R^T began
  p.u = moved.x * xyz(axes[0]) + moved.y * xyz(axes[1]) + moved.z * xyz(axes[2]);
  p.now = p.a + p.u;
  const bool container = traits.w > 0;
  const int kind = static_cast<int>(traits.x);
  if (kind == OBSTACLE_MESH && !k.meshes) return none;
  const Reach<real> reach = kind == OBSTACLE_MESH
                                ? mesh_distance(p, Vec3<real>{axes[0].w, axes[1].w, axes[2].w}, size.w,
                                                k.grid[o], k.grid_distance, container)
                                : shape_distance(kind, p, xyz(size));
  const real away = container ? -reach.d : reach.d, depth = k.radius - away;
  if (!(away < k.support)) return none;
  const Vec3<real> n = (container ? real(-1) : real(1)) * reach.normal;
  const Vec3<real> gradient{dot(xyz(axes[0]), n), dot(xyz(axes[1]), n), dot(xyz(axes[2]), n)};
  const real steep2 = dot(gradient, gradient);
  if (!(steep2 > 0)) return none;
  const Beyond<real> beyond(larger(away, k.radius) / k.support);
  const real slope = k.share * beyond.slope / (k.support * root(steep2));
  if (traits.z != OBSTACLE_GHOSTS)
    wall = {wall.x + slope * gradient.x, wall.y + slope * gradient.y, wall.z + slope * gradient.z,
            wall.w + k.share * beyond.share};
  if (!(depth > 0)) return none;
  const Vec3<real> push = (depth / steep2) * gradient;
  const Vec3<real> carried{dot(xyz(shift[0]), from) + shift[0].w, dot(xyz(shift[1]), from) + shift[1].w,
                           dot(xyz(shift[2]), from) + shift[2].w};
  Vec3<real> slide = moved - carried;
  slide = slide - (dot(gradient, slide) / steep2) * gradient;
  const real slid = norm(slide),
             held = traits.z == OBSTACLE_STICKS ? slid : smaller(slid, traits.y * norm(push));
  return held > 0 ? push - (held / slid) * slide : push;
}

} // namespace

template <class real> void fluid_project(const kernels::fluid_project::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    // Particles that are sorted next to each other are near each other: most parts are far from everything.
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> end = gather(k.fluid_place, part.index), start = gather(k.fluid_start, part.index);
    Wide4<real> moved = gather(k.fluid_moved, part.index);
    const WideMask<real> moves = end.w > 0;
    if (k.spread)
      moved = {moves ? end.x - start.x : moved.x, moves ? end.y - start.y : moved.y,
               moves ? end.z - start.z : moved.z, moved.w};
    const Wide3<real> y{start.x + moved.x, start.y + moved.y, start.z + moved.z};
    store(k.fluid_place + first, part.count,
          Wide4<real>{moves ? y.x : end.x, moves ? y.y : end.y, moves ? y.z : end.z, end.w});
    store(k.fluid_moved + first, part.count, moved);
    store(k.fluid_wall + first, part.count, Wide4<real>{});
    uint near = 0;
    for (uint o = 0; o < k.obstacles; ++o) {
      const auto* const rows = k.obstacle + OBSTACLE_ROWS * o;
      const auto centre = rows[OBSTACLE_CENTRE];
      near |=
          bits<real>(moves & may_touch(rows, {y.x - centre.x, y.y - centre.y, y.z - centre.z}, k.support));
    }
    for (; near; near &= near - 1) {
      const auto lane = static_cast<uint>(__builtin_ctz(near));
      if (lane >= part.count) break;
      const uint i = first + lane;
      Real4<real> wall{0, 0, 0, 0};
      const Vec3<real> began{start.x[lane], start.y[lane], start.z[lane]};
      Vec3<real> since{moved.x[lane], moved.y[lane], moved.z[lane]};
      for (uint o = 0; o < k.obstacles; ++o) since = since + pushed(k, o, began, since, wall);
      k.fluid_place[i] = {began.x + since.x, began.y + since.y, began.z + since.z, end.w[lane]};
      k.fluid_moved[i] = {since.x, since.y, since.z, moved.w[lane]};
      k.fluid_wall[i] = wall;
    }
  }
}

PLIANT_BODY(fluid_project)

} // namespace pliant::openmp::PLIANT_ISA
