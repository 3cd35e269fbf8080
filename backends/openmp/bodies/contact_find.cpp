// Contacts of each particle; see kernels/contact_find.decl.
#include "kernels/contact_find.h"
#include "backends/openmp/body.h"
#include "backends/openmp/cells.h"
#include "shaders/common/contact.glsl"

#include <memory>
#include <vector>

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

/// A place in one of the cells around, unless rows of cells share numbers: then it may be somewhere else.
struct Candidate {
  uint place;
  int y, z; // of its cell, if it is there
};

/// What a body's particles may touch around a cell, in which they are sorted next to each other.
/// `same_until`: from each place on the particles before this one are of the same body.
template <class View, class real>
PLIANT_INLINE void look_around(const View& k, Cell home, real body, bool own, const uint* same_until,
                               std::vector<Candidate>& candidates) {
  const uint cells = k.mask + 1;
  candidates.clear();
  for (int row = 0; row < 9; ++row) {
    const int y = home.y + row % 3 - 1, z = home.z + row / 3 - 1;
    // Three cells along x; their numbers may run over the end of the table.
    const uint first = cell_number(Cell{home.x - 1, y, z}, k.mask), last = first + 3;
    const uint from[2] = {first, 0}, to[2] = {smaller(last, cells), last > cells ? last - cells : 0};
    for (int part = 0; part < 2; ++part) {
      if (from[part] >= to[part]) continue;
      const uint end = k.cell_begin[to[part]];
      for (uint place = k.cell_begin[from[part]]; place < end;) {
        const uint until = smaller(same_until[place], end);
        if (k.sorted_place[place].w == body ? own : k.between)
          for (; place < until; ++place) candidates.push_back({place, y, z});
        place = until;
      }
    }
  }
}

} // namespace

template <class real> void contact_find(const kernels::contact_find::View<real>& k) {
  constexpr uint chunk = 512;
  const real reach2 = k.reach * k.reach;
  // Most particles are among their own body's only, which is passed over, as far as a chunk goes.
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
    std::vector<Candidate> candidates;
    Cell home{0, 0, 0};
    real body = -1;
#pragma omp for schedule(dynamic, chunk)
    for (uint place = 0; place < k.threads; ++place) {
      const uint i = k.sorted[place];
      const auto here = k.sorted_place[place];
      const Cell cell = cell_at(xyz(here), k.per_cell);
      if (here.w != body || cell.x != home.x || cell.y != home.y || cell.z != home.z) {
        home = cell;
        body = here.w;
        const bool own = k.within && k.self_contact[static_cast<uint>(body)];
        look_around(k, home, body, own, same_until.get(), candidates);
      }
      Nearest<real> nearest;
      for (const Candidate& other : candidates) {
        const auto there = k.sorted_place[other.place];
        const Vec3<real> away = xyz(there) - xyz(here);
        const real r2 = dot(away, away);
        if (!(r2 < reach2) || other.place == place) continue;
        // Rows may share numbers: only true members of this row count, and so each once.
        const Cell its = cell_at(xyz(there), k.per_cell);
        if (its.y != other.y || its.z != other.z || its.x < home.x - 1 || its.x > home.x + 1) continue;
        const uint j = k.sorted[other.place];
        if (there.w == body && bonded(k, i, j)) continue;
        nearest.offer(r2, j);
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
