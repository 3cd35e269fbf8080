// Lists of neighbours; see kernels/near_find.decl.
#include "kernels/near_find.h"
#include "backends/openmp/body.h"
#include "backends/openmp/lattice.h"
#include "backends/openmp/near.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// What lies around a cell and may be near one of its places, in the order of cells; the same for all of
/// them.
template <class real> struct Around {
  static constexpr uint room = 1024, nowhere = ~0u;
  uint cell = nowhere, count = 0; // nowhere: more than there is room for
  Vec3<real> centre{};            // of the cell, m
  alignas(64) real x[room + 16], y[room + 16], z[room + 16];
  uint index[room + 16], near[room + 16]; // near: of one place of the cell
};

/// Calls visit(begin, end) for the runs of sorted places in the cells around one.
template <class View, class Visit>
PLIANT_INLINE void for_each_run(const View& k, LatticeCell cell, Visit visit) {
  const auto first = [](uint at, uint cells) { return cells < 3 ? 0 : (at ? at - 1 : cells - 1); };
  const auto next = [](uint at, uint cells) { return at + 1 == cells ? 0 : at + 1; };
  const uint left = first(cell.x, k.cells_x), end = left + smaller(k.cells_x, 3u);
  uint z = first(cell.z, k.cells_z);
  for (uint dz = 0; dz < smaller(k.cells_z, 3u); ++dz, z = next(z, k.cells_z)) {
    uint y = first(cell.y, k.cells_y);
    for (uint dy = 0; dy < smaller(k.cells_y, 3u); ++dy, y = next(y, k.cells_y)) {
      const uint row = (z * k.cells_y + y) * k.cells_x;
      visit(k.cell_begin[row + left], k.cell_begin[row + smaller(end, k.cells_x)]);
      if (end > k.cells_x) visit(k.cell_begin[row], k.cell_begin[row + end - k.cells_x]); // it goes round
    }
  }
}

template <class View, class real>
PLIANT_INLINE Vec3<real> image(const View& k, const Vec3<real>& centre, const Real4<real>& place) {
  return {nearest_image(place.x, centre.x, k.period_x), nearest_image(place.y, centre.y, k.period_y),
          nearest_image(place.z, centre.z, k.period_z)};
}

/// How far a coordinate lies outside a box.
template <class real> PLIANT_INLINE Wide<real> beyond(Wide<real> at, real low, real high) {
  const Wide<real> below = low - at, above = at - high, most = below > above ? below : above, none{};
  return most > 0 ? most : none;
}

template <class View, class real>
PLIANT_INLINE void look_around(const View& k, LatticeCell cell, uint number, Around<real>& around) {
  around.cell = number;
  around.count = 0;
  around.centre = {(static_cast<real>(cell.x) + real(0.5)) / k.per_cell_x,
                   (static_cast<real>(cell.y) + real(0.5)) / k.per_cell_y,
                   (static_cast<real>(cell.z) + real(0.5)) / k.per_cell_z};
  // The box that the cell's own places fill: what is farther from it is far from each.
  constexpr real most = real(1e30);
  Vec3<real> low{most, most, most}, high{-most, -most, -most};
  for (uint j = k.cell_begin[number]; j < k.cell_begin[number + 1]; ++j) {
    const Vec3<real> p = image(k, around.centre, k.fluid_place[j]);
    low = {smaller(low.x, p.x), smaller(low.y, p.y), smaller(low.z, p.z)};
    high = {larger(high.x, p.x), larger(high.y, p.y), larger(high.z, p.z)};
  }
  const real enough = real(1.0001) * k.reach * k.reach;
  const bool repeats = k.period_x > 0 || k.period_y > 0 || k.period_z > 0;
  uint count = 0, all = 0;
  for_each_run(k, cell, [&](uint begin, uint end) {
    all += end - begin;
    if (all > Around<real>::room) return;
    for (uint j = begin; j < end; j += lanes<real>) {
      const Part<real> part = make_part<real>(j, end - j);
      Wide4<real> p = gather(k.fluid_place, part.index);
      if (repeats) {
        p.x = nearest_images<real>(p.x, around.centre.x, k.period_x);
        p.y = nearest_images<real>(p.y, around.centre.y, k.period_y);
        p.z = nearest_images<real>(p.z, around.centre.z, k.period_z);
      }
      const Wide3<real> away{beyond<real>(p.x, low.x, high.x), beyond<real>(p.y, low.y, high.y),
                             beyond<real>(p.z, low.z, high.z)};
      const Chosen<real> chosen(bits<real>(dot(away, away) < enough) & ((2u << (part.count - 1)) - 1));
      chosen.store(around.x + count, p.x);
      chosen.store(around.y + count, p.y);
      chosen.store(around.z + count, p.z);
      chosen.store(around.index + count, load_words<real>(part.index));
      count += chosen.count();
    }
  });
  if (all > Around<real>::room) {
    around.count = Around<real>::nowhere;
    return;
  }
  around.count = count;
  for (uint pad = count; pad < count + lanes<real>; ++pad)
    around.x[pad] = around.y[pad] = around.z[pad] = real(1e17);
}

} // namespace

template <class real> void near_find(const kernels::near_find::View<real>& k) {
  const real reach2 = k.reach * k.reach;
#pragma omp parallel
  {
    Around<real> around;
#pragma omp for schedule(static)
    for (uint slice = 0; slice < k.places / 16; ++slice) {
      uint* const lists = k.near + std::size_t{16} * k.rows * slice;
      uint length[16], longest = 0;
      for (uint lane = 0; lane < 16; ++lane) {
        const uint i = 16 * slice + lane;
        uint count = 0, lost = 0;
        const auto list = [&](uint j) {
          if (count < k.rows)
            lists[16 * count++ + lane] = j;
          else
            ++lost;
        };
        const auto own = k.fluid_place[i];
        if (own.w != 0) {
          const LatticeCell cell = lattice_at(k, xyz(own));
          const uint number = lattice_number(k, cell);
          if (number != around.cell) look_around(k, cell, number, around);
          const Vec3<real> p = image(k, around.centre, own);
          if (around.count != Around<real>::nowhere) {
            const Wide<real> x = spread(p.x), y = spread(p.y), z = spread(p.z);
            uint found = 0;
            for (uint at = 0; at < around.count; at += lanes<real>) {
              const Wide<real> dx = x - load_wide(around.x + at), dy = y - load_wide(around.y + at),
                               dz = z - load_wide(around.z + at);
              const Chosen<real> chosen(bits<real>(dx * dx + dy * dy + dz * dz < reach2));
              chosen.store(around.near + found, load_words<real>(around.index + at));
              found += chosen.count();
            }
            if (found <= k.rows) { // no branch but the loop's: the own place is overwritten
              for (uint at = 0; at < found; ++at) {
                lists[16 * count + lane] = around.near[at];
                count += around.near[at] != i;
              }
            } else {
              for (uint at = 0; at < found; ++at)
                if (around.near[at] != i) list(around.near[at]);
            }
          } else { // a crowd
            for_each_run(k, cell, [&](uint begin, uint end) {
              for (uint j = begin; j < end; ++j) {
                const Vec3<real> d = p - image(k, around.centre, k.fluid_place[j]);
                if (j != i && dot(d, d) < reach2) list(j);
              }
            });
          }
        }
        length[lane] = count;
        longest = larger(longest, count);
        if (lost > 0) {
          __atomic_fetch_add(&k.left_out[0], lost, __ATOMIC_RELAXED);
          __atomic_fetch_add(&k.left_out[1], 1u, __ATOMIC_RELAXED);
        }
      }
      for (uint lane = 0; lane < 16; ++lane)
        for (uint r = length[lane]; r < longest; ++r) lists[16 * r + lane] = 16 * slice + lane;
      k.near_count[slice] = longest;
    }
  }
}

PLIANT_BODY(near_find)

} // namespace pliant::openmp::PLIANT_ISA
