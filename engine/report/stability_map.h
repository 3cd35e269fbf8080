// The sweep as a picture: maps of Young's modulus and time step for each method and backend, then all other
// problems in a list.
#pragma once

#include "engine/report/stability.h"

namespace pliant {

/// stability.svg and stability.png. Throws Error(input_output).
void write_stability_map(const StabilityReport& report, const std::filesystem::path& folder);

} // namespace pliant
