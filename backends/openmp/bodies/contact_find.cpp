// Contacts of each particle; see kernels/contact_find.decl.
#include "kernels/contact_find.h"
#include "backends/openmp/body.h"
#include "backends/openmp/cells.h"
#include "shaders/common/contact.glsl"

#include <memory>

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// The nearest CONTACTS of those offered, nearest first; of two as near the one of smaller index.
template <class real> struct Nearest {
  uint count = 0, lost = 0;
  uint particle[CONTACTS];
  real distance2[CONTACTS];

  PLIANT_INLINE bool before(real r2, uint j, uint at) const {
    return r2 < distance2[at] || (r2 == distance2[at] && j < particle[at]);
  }
  PLIANT_INLINE void offer(real r2, uint j) {
    if (count == CONTACTS) {
      ++lost;
      if (!before(r2, j, CONTACTS - 1)) return;
    } else {
      ++count;
    }
    uint at = count - 1;
    for (; at > 0 && before(r2, j, at - 1); --at) {
      particle[at] = particle[at - 1];
      distance2[at] = distance2[at - 1];
    }
    particle[at] = j;
    distance2[at] = r2;
  }
  PLIANT_INLINE void order_by_index() {
    for (uint a = 1; a < count; ++a) {
      const uint j = particle[a];
      uint at = a;
      for (; at > 0 && particle[at - 1] > j; --at) particle[at] = particle[at - 1];
      particle[at] = j;
    }
  }
};

template <class View> PLIANT_INLINE bool bonded(const View& k, uint i, uint j) {
  for (uint range = 0; range < 4; ++range) {
    const auto law = k.law_range[range];
    if (i < law.x || i >= law.x + law.y) continue;
    const uint slice = law.z + (i - law.x) / 16, lane = (i - law.x) % 16;
    for (uint row = k.slice_begin[slice]; row < k.slice_begin[slice + 1]; ++row)
      if (k.bond[std::size_t{32} * row + lane] == j) return true;
  }
  return false;
}

/// Places whose cells follow one another along x, next to a cell.
struct Run {
  uint begin, end;
  int y, z;      // of their cells
  bool one_body; // all belong to that of the first
};

/// What lies around a cell: the same for all of its particles, which are sorted next to each other.
template <class View>
PLIANT_INLINE uint runs_around(const View& k, Cell home, const uint* same_until, Run (&runs)[18]) {
  const uint cells = k.mask + 1;
  uint count = 0;
  for (int row = 0; row < 9; ++row) {
    const int y = home.y + row % 3 - 1, z = home.z + row / 3 - 1;
    // Three cells along x; their numbers may run over the end of the table.
    const uint first = cell_number(Cell{home.x - 1, y, z}, k.mask), last = first + 3;
    const uint from[2] = {first, 0}, to[2] = {smaller(last, cells), last > cells ? last - cells : 0};
    for (int part = 0; part < 2; ++part) {
      if (from[part] >= to[part]) continue;
      const uint begin = k.cell_begin[from[part]], end = k.cell_begin[to[part]];
      if (begin < end) runs[count++] = {begin, end, y, z, same_until[begin] >= end};
    }
  }
  return count;
}

} // namespace

template <class real> void contact_find(const kernels::contact_find::View<real>& k) {
  constexpr uint chunk = 512;
  const real reach2 = k.reach * k.reach;
  // Most particles are among their own body's only. From each place on, as far as its chunk goes, this many
  // are of one.
  const auto same_until = std::make_unique_for_overwrite<uint[]>(k.threads);
#pragma omp parallel
  {
#pragma omp for schedule(static)
    for (uint first = 0; first < k.threads; first += chunk) {
      uint until = smaller(first + chunk, k.threads);
      for (uint place = until; place-- > first;) {
        if (place + 1 < until && k.sorted_place[place].w != k.sorted_place[place + 1].w) until = place + 1;
        same_until[place] = until;
      }
    }
    Run runs[18];
    uint count = 0;
    Cell home{0, 0, 0};
#pragma omp for schedule(dynamic, chunk)
    for (uint place = 0; place < k.threads; ++place) {
      const uint i = k.sorted[place];
      const auto here = k.sorted_place[place];
      const Cell cell_here = cell_at(xyz(here), k.per_cell);
      if (count == 0 || cell_here.x != home.x || cell_here.y != home.y || cell_here.z != home.z) {
        home = cell_here;
        count = runs_around(k, home, same_until.get(), runs);
      }
      const bool own = k.within && k.self_contact[static_cast<uint>(here.w)];
      const real limit_own = own ? reach2 : real(0), limit_more = (k.between ? reach2 : real(0)) - limit_own;
      Nearest<real> nearest;
      for (uint r = 0; r < count; ++r) {
        const Run& run = runs[r];
        if (!own && run.one_body && k.sorted_place[run.begin].w == here.w) continue;
        for (uint other = run.begin; other < run.end; ++other) {
          const auto there = k.sorted_place[other];
          const Vec3<real> away = xyz(there) - xyz(here);
          const real r2 = dot(away, away);
          // One branch a candidate, which rarely goes the other way: the limit is 0 for a body not wanted.
          const real gap = there.w - here.w, differs = smaller(gap * gap, real(1));
          if (!(r2 < limit_own + differs * limit_more) || other == place) continue;
          // Rows may share numbers: only true members of this row count, and so each once.
          const Cell cell = cell_at(xyz(there), k.per_cell);
          if (cell.y != run.y || cell.z != run.z || cell.x < home.x - 1 || cell.x > home.x + 1) continue;
          const uint j = k.sorted[other];
          if (there.w == here.w && bonded(k, i, j)) continue;
          nearest.offer(r2, j);
        }
      }
      nearest.order_by_index();
      uint* list = k.contact + std::size_t{CONTACTS * 16} * (i / 16) + i % 16;
      for (uint a = 0; a < nearest.count; ++a) list[16 * a] = nearest.particle[a];
      if (nearest.count < CONTACTS) list[16 * nearest.count] = i;
      if (nearest.lost > 0) {
        __atomic_fetch_add(&k.left_out[0], nearest.lost, __ATOMIC_RELAXED);
        __atomic_fetch_add(&k.left_out[1], 1u, __ATOMIC_RELAXED);
      }
    }
  }
}

PLIANT_BODY(contact_find)

} // namespace pliant::openmp::PLIANT_ISA
