// From a kernel's name to its body, for each precision and instruction set.
#pragma once

#include "engine/device/device.h"

#include <string_view>

namespace pliant::openmp {

using Data = void* (*)(const BufferStorage*);
using Body = void (*)(const void* args, Data data);

/// The body of a kernel for the widest instruction set of this processor; null when there is none.
Body find_body(std::string_view kernel, Precision precision);

// One table for each instruction set, all from table_isa.cpp.
using Lookup = Body (*)(std::string_view kernel, Precision precision);

} // namespace pliant::openmp
