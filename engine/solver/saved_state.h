// What a step leaves to the next, as the device stores it: the one list of it, and copies of it on the host
// and on the device.
//
//   save(), load()    raw bytes on the host: checkpoints
//   keep(), rewind()  copies on the device: the last state known to be good
//
// Everything else on the device is made anew in each step, or never changes.
#pragma once

#include "engine/device/device.h"

#include <cstdint>
#include <string>
#include <vector>

namespace pliant {

struct Plan;

/// Buffers whose content a later step reads; this plan may lack some of them. A component that carries
/// something from step to step adds its buffer here, and it is saved, kept and restored.
std::vector<std::string> persistent_buffers(const Plan& plan);
/// Name of the buffer that holds the copy of another.
inline std::string kept_name(const std::string& name) {
  return "kept_" + name;
}

struct SavedBuffer {
  std::string name;
  Type type = Type::real;
  std::vector<std::byte> bytes; ///< in the device's layout and precision
};

struct SavedState {
  std::uint64_t step = 0;
  bool first_of_bdf2 = true; ///< the next step has no history
  std::vector<SavedBuffer> buffers;
};

} // namespace pliant
