// Random values of particles without bonds, for kernels that look at one particle at a time.
#pragma once

#include "tests/support/kernel_bonds.h"

namespace pliant::test {

inline constexpr std::size_t behind = 40; ///< sentinels behind the last particle

/// Groups of four, exact in float, within +-size.
inline std::vector<double> random_groups(Random& random, std::size_t count, double size) {
  std::vector<double> values(4 * count);
  for (double& value : values) value = random(size);
  return values;
}
/// The same with sentinels behind.
inline std::vector<double> guarded(std::vector<double> values, std::size_t width) {
  values.insert(values.end(), width * behind, sentinel);
  return values;
}
inline Vector3 vector_at(const std::vector<double>& groups, std::size_t i) {
  return {groups[4 * i], groups[4 * i + 1], groups[4 * i + 2]};
}
inline void set_vector(Expected& expected, std::size_t i, const Vector3& value, const Vector3& scale) {
  for (int k = 0; k < 3; ++k) expected.set(4 * i + static_cast<std::size_t>(k), value[k], scale[k]);
}

} // namespace pliant::test
