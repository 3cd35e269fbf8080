// A debugging switch: each kernel of a live run is run again on a second device, from the same buffers, and the
// first result that differs stops the run.
#pragma once

#include "engine/device/device.h"

#include <memory>

namespace pliant {

/// Largest difference that two devices may show: this share of the largest magnitude in the buffer. Float
/// rounding over a few hundred terms stays near 1e-5; a wrong term shows up above 1e-2. Integers must be equal, and
/// so must the places of NaN and infinity.
inline constexpr double replay_tolerance = 1e-3;

/// Behaves as `device`; runs every dispatch on `reference` as well. Throws Error(internal) at the first mismatch,
/// with kernel, buffer, element, both values and the number of the dispatch (from 1).
std::unique_ptr<Device> make_replay_device(std::unique_ptr<Device> device, std::unique_ptr<Device> reference);

/// The device whose buffers these are: the live one within a replay device, any other itself.
Device& unwrapped(Device& device);

} // namespace pliant
