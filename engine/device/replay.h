// A debugging switch: each kernel of a live run is run again on a second device, from the same buffers, and
// the first result that differs stops the run.
#pragma once

#include "engine/device/device.h"

#include <memory>

namespace pliant {

/// Largest difference that two devices may show: this share of the largest magnitude in the buffer. Float
/// rounding over a few hundred terms stays near 1e-5; a wrong term shows up above 1e-2. Integers must be
/// equal, and so must the places of NaN and infinity.
inline constexpr double replay_tolerance = 1e-3;

/// What rounding may make of a kernel's input, relative. Where a result differs, the reference runs again
/// with one input at a time larger and smaller by this; where it then gives what the live device gave, a
/// decision was at a tie (a residual no smaller than the best but for a rounding, a neighbour at the reach),
/// and both are right.
inline constexpr double replay_rounding = 1e-5;

/// Behaves as `device`; runs every dispatch on `reference` as well. Throws Error(internal) at the first
/// mismatch, with kernel, buffer, element, both values and the number of the dispatch (from 1).
std::unique_ptr<Device> make_replay_device(std::unique_ptr<Device> device, std::unique_ptr<Device> reference);

/// Results so far that fell to the other side of a tie; 0 of any other device.
std::size_t replay_ties(const Device& device);

/// The device whose buffers these are: the live one within a replay device, any other itself.
Device& unwrapped(Device& device);

} // namespace pliant
