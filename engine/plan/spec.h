// What a component will allocate and run, known before anything is allocated.
#pragma once

#include "kernels/kernel.h"

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
