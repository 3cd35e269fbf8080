// The CPU device: kernels as OpenMP loops, in float or double.
#pragma once

#include "engine/device/device.h"

#include <memory>

namespace pliant::openmp {

std::unique_ptr<Device> make_device(Precision precision, unsigned threads);
DeviceListing describe();

/// The instruction set that bodies run with here: "x86-64-v4", "x86-64-v3" or "baseline".
const char* instruction_set();

} // namespace pliant::openmp
