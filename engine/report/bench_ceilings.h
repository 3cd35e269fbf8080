// What a machine can do at best: the roof over every kernel's time.
#pragma once

#include "engine/device/device.h"

namespace pliant {

/// GB/s are 1e9 bytes a second. A value that was not measured is 0.
struct Ceilings {
  double read_memory = 0, read_l3 = 0, read_l2 = 0; ///< GB/s, all threads together
  double fma = 0;                                   ///< GFLOP/s in 32 bits, two a multiply-add
  double copy = 0;                                  ///< GB/s read plus written, of the device's own copy

  /// GB/s at which `bytes` could be streamed again and again.
  double bandwidth(double bytes) const;
};

Ceilings measure_ceilings(Device& device);

} // namespace pliant
