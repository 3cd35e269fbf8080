// Lists of neighbours; see kernels/near_find.decl. All places of a cell look at the same candidates, which
// are put together once; lists are made one after another and turned into the slice's columns in registers.
#include "kernels/near_find.h"
#include "backends/openmp/body.h"
#include "backends/openmp/lattice.h"
#include "backends/openmp/near.h"
#include "backends/openmp/simd_runs.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

// So many have lists of some 40 MB. Below, the sweeps that follow find them in the caches.
constexpr uint many_places = 1u << 18;

/// What lies around a cell, in the order of cells: the same for all of its places.
template <class real> struct Around {
  static constexpr uint room = 1024 - 16;
  alignas(4096) real x[room + 16], y[room + 16], z[room + 16];
  uint index[room + 16];
  uint begin = 0, end = 0; // of the cell's own places
  uint count = 0, own = 0; // own: where the first of these stands
  LatticeCell cell{};
  Vec3<real> centre{}; // of the cell, m

  bool crowd() const { return count > room; }
};

/// Lists of a slice's places. A load waits for a store under way to an address that agrees in its low 12
/// bits; lists therefore begin where Around<float>, which is read while they are written, is seldom in use.
struct Lists {
  static constexpr uint room = 2048;
  alignas(4096) uint unused[448];
  uint of[16][room + 32];
  alignas(64) uint length[16];
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

template <class View, class real>
PLIANT_INLINE void look_around(const View& k, LatticeCell cell, Around<real>& around) {
  const uint number = lattice_number(k, cell);
  around.cell = cell;
  around.begin = k.cell_begin[number];
  around.end = k.cell_begin[number + 1];
  around.centre = {(static_cast<real>(cell.x) + real(0.5)) / k.per_cell_x,
                   (static_cast<real>(cell.y) + real(0.5)) / k.per_cell_y,
                   (static_cast<real>(cell.z) + real(0.5)) / k.per_cell_z};
  const bool repeats = k.period_x > 0 || k.period_y > 0 || k.period_z > 0;
  uint count = 0;
  for_each_run(k, cell, [&](uint begin, uint end) {
    uint at = count;
    count += end - begin;
    if (count > Around<real>::room) return;
    if (around.begin - begin < end - begin) around.own = at + (around.begin - begin);
    uint j = begin;
    for (; j < end && j + lanes<real> <= k.places; j += lanes<real>, at += lanes<real>) {
      Wide4<real> p = gather_run(k.fluid_place + j);
      if (repeats) {
        p.x = nearest_images<real>(p.x, around.centre.x, k.period_x);
        p.y = nearest_images<real>(p.y, around.centre.y, k.period_y);
        p.z = nearest_images<real>(p.z, around.centre.z, k.period_z);
      }
      const WideInt<real> index = counted<real>(j);
      __builtin_memcpy(around.x + at, &p.x,
                       sizeof p.x); // the next run writes over what is past this one's end
      __builtin_memcpy(around.y + at, &p.y, sizeof p.y);
      __builtin_memcpy(around.z + at, &p.z, sizeof p.z);
      __builtin_memcpy(around.index + at, &index, sizeof index);
    }
    for (; j < end; ++j, ++at) { // the last places of all
      const Vec3<real> p = image(k, around.centre, k.fluid_place[j]);
      around.x[at] = p.x, around.y[at] = p.y, around.z[at] = p.z;
      around.index[at] = j;
    }
  });
  around.count = count;
  if (around.crowd()) return;
  for (uint pad = count; pad < count + lanes<real>; ++pad)
    around.x[pad] = around.y[pad] = around.z[pad] = real(1e17);
}

/// Lists what is near place i, one of the cell's own; returns how many.
template <class real> PLIANT_INLINE uint list_near(Around<real>& around, uint i, real reach2, uint* list) {
  const uint own = around.own + (i - around.begin);
  const Wide<real> x = spread(around.x[own]), y = spread(around.y[own]), z = spread(around.z[own]);
  const real kept = around.x[own];
  around.x[own] = real(1e17); // nobody is near himself
  std::size_t found = 0;
  for (std::size_t at = 0, all = around.count; at < all; at += lanes<real>) {
    const Wide<real> dx = x - load_wide(around.x + at), dy = y - load_wide(around.y + at),
                     dz = z - load_wide(around.z + at);
    const Chosen<real> chosen(bits<real>(dx * dx + dy * dy + dz * dz < reach2));
    chosen.store(list + found, load_words<real>(around.index + at));
    found += chosen.count();
  }
  around.x[own] = kept;
  return static_cast<uint>(found);
}

/// The same without what has been put together. No more than `room` are listed, but all are counted.
template <class View, class real>
uint list_one_by_one(const View& k, const Around<real>& around, uint i, uint room, uint* list) {
  const Vec3<real> p = image(k, around.centre, k.fluid_place[i]);
  uint found = 0;
  for_each_run(k, around.cell, [&](uint begin, uint end) {
    for (uint j = begin; j < end; ++j) {
      const Vec3<real> d = p - image(k, around.centre, k.fluid_place[j]);
      if (j == i || !(dot(d, d) < k.reach * k.reach)) continue;
      if (found < room) list[found] = j;
      ++found;
    }
  });
  return found;
}

/// Lists of a slice as columns, `rows` of them; a shorter one ends in its own place. `many`: caches shall not
/// keep them.
PLIANT_INLINE void write_columns(const Lists& lists, uint rows, uint first, bool many, uint* to) {
  using Block = WideInt<float>;
  constexpr uint wide = lanes<float>;
  for (uint row = 0; row < rows; row += wide) {
    const uint count = smaller(rows - row, wide);
    for (uint lane = 0; lane < 16; lane += wide) {
      const Block self = counted<float>(first + lane), length = load_words<float>(lists.length + lane);
      Block block[wide];
      for (uint l = 0; l < wide; ++l) block[l] = load_words<float>(lists.of[lane + l] + row);
      turn(block);
      for (uint r = 0; r < wide; ++r) {
        if (r == count) break;
        const Block value = length > static_cast<std::int32_t>(row + r) ? block[r] : self;
        uint* const at = to + 16 * (row + r) + lane;
        if (many)
          store_past_caches(at, value);
        else
          __builtin_memcpy(at, &value, sizeof value);
      }
    }
  }
}

} // namespace

template <class real> void near_find(const kernels::near_find::View<real>& k) {
  const real reach2 = k.reach * k.reach;
  const uint room = smaller(k.rows, Lists::room);
  const bool many = k.places > many_places;
#pragma omp parallel
  {
    Around<real> around;
    Lists lists;
#pragma omp for schedule(static)
    for (uint slice = 0; slice < k.places / 16; ++slice) {
      uint longest = 0;
      for (uint lane = 0; lane < 16; ++lane) {
        const uint i = 16 * slice + lane;
        const auto own = k.fluid_place[i];
        uint found = 0;
        if (own.w > 0 || (own.w < 0 && k.fluid_particle[i] < k.particle_count)) {
          const auto inside = [&] { return i - around.begin < around.end - around.begin; };
          if (!inside()) look_around(k, lattice_at(k, xyz(own)), around);
          // Rounding may have sorted a place that lies between two cells into the other.
          found = inside() && !around.crowd() ? list_near(around, i, reach2, lists.of[lane])
                                              : list_one_by_one(k, around, i, room, lists.of[lane]);
        }
        lists.length[lane] = smaller(found, room);
        longest = larger(longest, lists.length[lane]);
        if (found > room) {
          __atomic_fetch_add(&k.left_out[0], found - room, __ATOMIC_RELAXED);
          __atomic_fetch_add(&k.left_out[1], 1u, __ATOMIC_RELAXED);
        }
      }
      write_columns(lists, longest, 16 * slice, many, k.near + std::size_t{16} * k.rows * slice);
      k.near_count[slice] = longest;
    }
    flush_stores();
  }
}

PLIANT_BODY(near_find)

} // namespace pliant::openmp::PLIANT_ISA
