// Fluids with bonds for tests of kernels: lists with a rest length for each entry, the same at both ends.
#pragma once

#include "engine/model/fluid_bonds.h"
#include "shaders/common/fluid_bond.glsl"
#include "tests/support/near_lists.h"

#include <functional>

namespace pliant::test {

/// Rest length of the bond between two places; 0: none; BOND_NEW.
using RestOf = std::function<double(std::size_t, std::size_t)>;

/// Weights as a material's at the default reach are, exact in float.
inline std::array<double, 3> kernel_weights() {
  return {0, 0.25, 0.125}; // neighbourhoods inside sum to more than FULL_BONDS, at surfaces to less
}
inline double weight_at(const NearCloud& cloud, const Vector3& y) {
  const auto w = kernel_weights();
  const double per = rounded(1 / (cloud.support_in_float() * cloud.support_in_float()));
  const double q = std::min(y.squaredNorm() * per, 1.0);
  return (1 - q) * (1 - q) * (w[0] + q * (w[1] + q * w[2]));
}

/// near, near_count, rows, periods, fluid_place, fluid_start (at the same places), fluid_was (one family, and
/// ghosts where masses are negative), near_rest as `rest` gives it, weights.
inline Values bond_values(const NearCloud& cloud, const RestOf& rest) {
  Values in = cloud.values();
  const auto list = cloud.lists();
  const auto rows = static_cast<std::size_t>(in["rows"][0]);
  std::vector<double>& rests = in["near_rest"];
  rests.assign(in["near"].size(), 0);
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t r = 0; r < list[i].size(); ++r)
      rests[16 * (rows * (i / 16) + r) + i % 16] = rest(i, list[i][r]);
  in["fluid_start"] = in["fluid_place"];
  for (std::size_t i = 0; i < cloud.places(); ++i) {
    const bool ghost = i < cloud.mass.size() && cloud.mass[i] < 0;
    in["fluid_was"].insert(in["fluid_was"].end(), {0, ghost ? double(FAMILY_GHOST) : 1, double(i), 1});
  }
  const auto w = kernel_weights();
  in["weight_0"] = {w[0]}, in["weight_2"] = {w[1]}, in["weight_4"] = {w[2]};
  in["per_reach2"] = {rounded(1 / (cloud.support_in_float() * cloud.support_in_float()))};
  return in;
}

/// Calls visit(i, j, entry) for each entry of a list.
inline void for_each_entry(const NearCloud& cloud, const Values& in,
                           const std::function<void(std::size_t, std::size_t, std::size_t)>& visit) {
  const auto list = cloud.lists();
  const auto rows = static_cast<std::size_t>(in.at("rows")[0]);
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t r = 0; r < list[i].size(); ++r)
      visit(i, list[i][r], 16 * (rows * (i / 16) + r) + i % 16);
}

/// A number of the pair, the same for both orders, in [-1, 1).
inline double pair_number(std::size_t i, std::size_t j, unsigned seed) {
  std::mt19937 random(static_cast<unsigned>(std::min(i, j) * 7919 + std::max(i, j)) ^ seed);
  random.discard(3);
  return static_cast<double>(random()) / 2147483648.0 - 1;
}

} // namespace pliant::test
