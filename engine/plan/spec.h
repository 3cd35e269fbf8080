// What a component says it needs, before anything is allocated or compiled.
#pragma once

#include "kernels/kernel.h"

#include <cstddef>
#include <string>

namespace pliant {

struct BufferSpec {
  std::string name;
  Type type = Type::real;
  std::size_t count = 0;
  std::string component;
};

struct KernelSpec {
  const KernelInfo* info = nullptr;
  std::string component;
};

} // namespace pliant
