// What a scene's bodies must satisfy before they are simulated.
#pragma once

#include "engine/model/arrange.h"

#include <optional>

namespace pliant {

/// Why a body has too few particles for its horizon, as the end of a sentence; nothing where it has enough:
/// at least 8, of which at most a tenth have fewer than 4 neighbours, 3 where they are `flat`.
std::optional<std::string> sparseness(const Bonds& bonds, bool flat = false);

struct Overlap {
  std::uint32_t body; ///< the second of the deepest pair
  std::string text;   ///< a sentence that names the pair
};
/// Bodies whose particles come closer than half a spacing at t = 0; nothing where none do.
std::optional<Overlap> overlap(const Model& model);

} // namespace pliant
