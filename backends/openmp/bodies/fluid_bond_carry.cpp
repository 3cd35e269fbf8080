// Rest lengths that go on; see kernels/fluid_bond_carry.decl.
#include "kernels/fluid_bond_carry.h"
#include "backends/openmp/body.h"
#include "backends/openmp/simd.h"
#include "shaders/common/fluid_bond.glsl"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// A list of the step before: a column of its slice, put together when it is first searched.
class ListThen {
public:
  ListThen(const uint* list, uint count) : list_(list), count_(count) {}
  uint count() const { return count_; }
  PLIANT_INLINE uint operator[](uint r) const { return list_[std::size_t{16} * r]; }

  /// Where `wanted` stands; count() if it does not.
  PLIANT_INLINE uint find(uint wanted) {
    if (count_ > room) {
      for (uint r = 0; r < count_; ++r)
        if ((*this)[r] == wanted) return r;
      return count_;
    }
    for (; copied_ < count_; ++copied_) together_[copied_] = (*this)[copied_];
    const WideInt<float> all = static_cast<std::int32_t>(wanted) - WideInt<float>{};
    for (uint r = 0; r < count_; r += lanes<float>) {
      const WideMask<float> same = (WideMask<float>)(load_words<float>(together_ + r) == all);
      if (const uint found = bits<float>(same))
        return smaller(r + static_cast<uint>(__builtin_ctz(found)), count_);
    }
    return count_;
  }

private:
  static constexpr uint room = 128;
  const uint* list_;
  uint count_, copied_ = 0;
  uint together_[room + lanes<float>]; // what is past the end is not the list's
};

} // namespace

template <class real> void fluid_bond_carry(const kernels::fluid_bond_carry::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint slice = 0; slice < (k.threads + 15) / 16; ++slice) {
    const uint count = k.near_count[slice], last = smaller(16 * slice + 16, k.threads);
    for (uint i = 16 * slice; i < last; ++i) {
      const auto own = k.fluid_was[i];
      if (own.w) k.near_place_of[own.z] = i;
      const std::size_t first = std::size_t{16} * k.rows * slice + i % 16;
      if (own.y == 0 || own.y == FAMILY_GHOST) {
        for (uint r = 0; r < count; ++r) k.near_rest[first + std::size_t{16} * r] = 0;
        continue;
      }
      const std::size_t first_then = std::size_t{16} * k.rows * (own.x / 16) + own.x % 16;
      const real* const rest_then = k.near_rest_earlier + first_then;
      ListThen then(k.near_earlier + first_then, k.near_count_earlier[own.x / 16]);
      uint at = 0; // lists keep most of their order
      for (uint r = 0; r < count; ++r) {
        const std::size_t entry = first + std::size_t{16} * r;
        const uint j = k.near[entry];
        if (j == i) { // the rest is padding
          for (uint end = r; end < count; ++end) k.near_rest[first + std::size_t{16} * end] = 0;
          break;
        }
        const auto other = k.fluid_was[j];
        const bool bonds = other.y == own.y || other.y == FAMILY_GHOST;
        real rest = bonds ? real(BOND_NEW) : 0;
        if (bonds && other.x != own.x) {
          const uint found = at < then.count() && then[at] == other.x ? at : then.find(other.x);
          if (found < then.count()) {
            at = found + 1;
            const real before = rest_then[std::size_t{16} * found];
            rest = before > 0 ? before : rest;
          }
        }
        k.near_rest[entry] = rest;
      }
    }
  }
}

PLIANT_BODY(fluid_bond_carry)

} // namespace pliant::openmp::PLIANT_ISA
