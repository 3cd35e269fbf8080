// Shifts that spread particles; see kernels/fluid_redistribute.decl.
#include "kernels/fluid_redistribute.h"
#include "backends/openmp/body.h"
#include "backends/openmp/near.h"
#include "backends/openmp/pairs.h"
#include "backends/openmp/smoothing.h"
#include "shaders/common/fluid.glsl"
#include "shaders/common/spread.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

template <class real> PLIANT_INLINE void add_scaled(Wide3<real>& sum, Wide<real> s, const Wide3<real>& v) {
  sum.x += s * v.x, sum.y += s * v.y, sum.z += s * v.z;
}

// Directions of pairs in one place, which they must agree on.
template <class real>
PLIANT_INLINE void part_pairs(const uint* own, const uint* theirs, WideMask<real> together, Wide3<real>& n) {
  for (uint lane = 0; lane < lanes<real>; ++lane) {
    if (!together[lane]) continue;
    const Vec3<real> away = real(-1) * agreed_direction<real>(own[lane], theirs[lane]);
    n.x[lane] = away.x, n.y[lane] = away.y, n.z[lane] = away.z;
  }
}

// Whether all pairs of a part push by its own limits, far from any surface: then their sum is known, it is
// that of the gradient. Most particles inside are such.
template <class real>
PLIANT_INLINE bool is_plain(const kernels::fluid_redistribute::View<real>& k, uint first, Wide<real> mark,
                            Wide<real> nearest) {
  WideMask<real> special = mark < 0;
  if (k.tension) special |= nearest < real(SPREAD_APART) * k.spacing;
  const uint slice = first / 16, count = k.near_count[slice];
  const uint* row = k.near + (std::size_t{16} * k.rows * slice + first % 16);
  for (uint r = 0; r < count; ++r, row += 16) {
    if (r % 8 == 0 && bits<real>(special)) return false;
    Wide<real> theirs;
    for (uint lane = 0; lane < lanes<real>; ++lane) theirs[lane] = k.fluid_normal[row[lane]].w;
    special |= theirs < mark;
  }
  return !bits<real>(special);
}

template <uint form, class real>
PLIANT_INLINE void redistribute(const kernels::fluid_redistribute::View<real>& k) {
  const Wide<real> none{}, one = none + 1;
  const real per_support = 1 / k.support;
  const real reach = real(SPREAD_FAR) * k.spacing,
             per_width = 1 / (real(SPREAD_FAR - SPREAD_NEAR) * k.spacing);
  const real apart = real(SPREAD_APART) * k.spacing;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    const Wide4<real> place = gather(k.fluid_place, part.index), normal = gather(k.fluid_normal, part.index);
    const Wide<real> limit = magnitudes<real>(normal.w);
    const WideMask<real> moves = place.w > 0;
    if (form == 0 && !k.mixed) {
      const Wide4<real> g = gather(k.fluid_gradient, part.index);
      if (is_plain<real>(k, first, normal.w, moves ? g.w : spread(k.support))) {
        const Wide<real> by = moves ? -k.rate * limit : none;
        store(k.fluid_shift + first, part.count,
              Wide4<real>{place.x + by * g.x, place.y + by * g.y, place.z + by * g.z, place.w});
        continue;
      }
    }
    Wide<real> marked = normal.w < 0 ? one : none;
    Wide3<real> mean{normal.x, normal.y, normal.z}, all{}, close{};
    const Wide4<real> newton = form > 0 ? gather(k.fluid_newton, part.index) : Wide4<real>{};
    const auto push_apart = [&](const uint* neighbours, const Wide4<real>& d4, WideMask<real> self)
        __attribute__((always_inline)) {
      const Wide4<real> there = gather_near(k.fluid_normal, neighbours);
      const Wide3<real> d{d4.x, d4.y, d4.z};
      const Wide<real> far = root_wide<real>(dot(d, d)), q = far * per_support;
      const Wide<real> per_q = 1 / (q + real(1e-18)); // where places coincide the differences vanish
      Wide<real> share = one;
      if (k.mixed) {
        const Wide<real> mass = magnitudes<real>(d4.w), total = place.w + mass;
        share = 2 * mass / (total > 0 ? total : one);
      }
      Wide<real> weight = there.w < 0 ? within(q) : none;
      weight = self ? none : weight;
      add_scaled<real>(mean, weight, {there.x, there.y, there.z});
      marked += weight;
      const Wide<real> slope = k.slope_scale * spiky_slope(q, per_q), per_far = per_support * per_q;
      Wide3<real> n{per_far * d.x, per_far * d.y, per_far * d.z};
      if constexpr (form == 0) {
        const Wide<real> theirs = magnitudes<real>(there.w), both = limit < theirs ? limit : theirs;
        const Wide<real> push = -share * k.rate * both * slope;
        Wide<real> gate = (reach - far) * per_width;
        gate = gate < 1 ? gate : one;
        gate = gate > 0 ? gate : none;
        add_scaled<real>(all, push, d);
        add_scaled<real>(close, gate * push, d);
      } else if constexpr (form == 1) {
        const Wide4<real> other = gather(k.fluid_newton, neighbours);
        const Wide3<real> v{newton.x - other.x, newton.y - other.y, newton.z - other.z};
        add_scaled<real>(all, -share * slope, v);
        add_scaled<real>(all, -share * (k.curvature_scale * spiky_curvature(q) - slope) * dot(n, v), n);
      } else {
        Wide<real> theirs;
        for (uint lane = 0; lane < lanes<real>; ++lane) theirs[lane] = k.fluid_newton[neighbours[lane]].w;
        add_scaled<real>(all, share * k.rate * (newton.w + theirs) * slope / 2, d);
      }
      if (k.tension) {
        const WideMask<real> together = (far <= real(1e-6) * k.spacing) & ~self;
        if (bits<real>(together)) part_pairs<real>(part.index, neighbours, together, n);
        const Wide<real> missing = share * (real(SPREAD_APART_RATE) * (apart - far));
        Wide<real> by = far < apart ? missing : none;
        by = self ? none : by;
        add_scaled<real>(all, by, n);
        if constexpr (form == 0) add_scaled<real>(close, by, n);
      }
    };
    for_each_near(k, part, place, push_apart);
    const WideMask<real> near_surface = marked > 0;
    Wide3<real> shift = all;
    if constexpr (form == 0)
      shift = {near_surface ? close.x : all.x, near_surface ? close.y : all.y,
               near_surface ? close.z : all.z};
    const Wide<real> per_marked = 1 / (near_surface ? marked : one);
    mean = {per_marked * mean.x, per_marked * mean.y, per_marked * mean.z};
    const Wide<real> length2 = dot(mean, mean), part_of = root_wide<real>(length2) / real(SURFACE_FULL);
    const Wide<real> removed =
        -(part_of < 1 ? part_of : one) / (length2 > 0 ? length2 : one) * dot(mean, shift);
    add_scaled<real>(shift, near_surface ? removed : none, mean);
    if (k.tension) {
      Wide<real> pull{};
      for (uint lane = 0; lane < lanes<real>; ++lane) {
        if (!(normal.w[lane] < 0)) continue;
        const uint material = static_cast<uint>(static_cast<int>(k.fluid_velocity[part.index[lane]].w));
        pull[lane] = k.pull * k.fluid_material[FLUID_ROWS * material + FLUID_TRAITS].w;
      }
      add_scaled<real>(shift, pull, {normal.x, normal.y, normal.z});
    }
    store(k.fluid_shift + first, part.count,
          Wide4<real>{moves ? place.x + shift.x : place.x, moves ? place.y + shift.y : place.y,
                      moves ? place.z + shift.z : place.z, place.w});
  }
}

} // namespace

template <class real> void fluid_redistribute(const kernels::fluid_redistribute::View<real>& k) {
  if (k.form == 0)
    redistribute<0>(k);
  else if (k.form == 1)
    redistribute<1>(k);
  else
    redistribute<2>(k);
}

PLIANT_BODY(fluid_redistribute)

} // namespace pliant::openmp::PLIANT_ISA
