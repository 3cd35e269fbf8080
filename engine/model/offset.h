// Reference positions as integers, and bond vectors packed into 32 bits.
#pragma once

#include "engine/model/model.h"

#include <array>
#include <cstdint>
#include <vector>

namespace pliant {

/// Multiples of spacing / reference_grid.
using GridVector = std::array<std::int32_t, 3>;

/// Largest component of a bond vector that ten signed bits hold.
inline constexpr std::int32_t offset_reach = 511;

/// Nearest grid vectors of reference positions. Throws Error(usage) for what is not finite or beyond 32 bits.
std::vector<GridVector> to_grid(const std::vector<Vector3>& reference, double spacing);

inline Vector3 from_grid(const GridVector& v, double spacing) {
  return Vector3(v[0], v[1], v[2]) * (spacing / reference_grid);
}

inline GridVector operator-(const GridVector& a, const GridVector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Three signed fields of ten bits, x lowest; the top two bits are zero.
inline std::uint32_t pack_offset(const GridVector& v) {
  const auto field = [](std::int32_t c) { return static_cast<std::uint32_t>(c) & 1023u; };
  return field(v[0]) | field(v[1]) << 10 | field(v[2]) << 20;
}

inline GridVector unpack_offset(std::uint32_t packed) {
  const auto field = [packed](unsigned shift) {
    const auto bits = static_cast<std::int32_t>(packed >> shift & 1023u);
    return bits < 512 ? bits : bits - 1024;
  };
  return {field(0), field(10), field(20)};
}

/// Squared length in grid units.
inline std::int64_t squared_length(const GridVector& v) {
  return std::int64_t{v[0]} * v[0] + std::int64_t{v[1]} * v[1] + std::int64_t{v[2]} * v[2];
}

} // namespace pliant
