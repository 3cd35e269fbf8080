// What a component says it needs, before anything is allocated or compiled.
#pragma once

#include "kernels/kernel.h"

#include <cstddef>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

struct BufferSpec {
  std::string name;
  Type type = Type::real;
  std::size_t count = 0;
  std::string component;
};

/// One variant of a kernel: its options are fixed when it is compiled.
struct KernelSpec {
  const KernelInfo* info = nullptr;
  std::string component;
  std::vector<std::uint32_t> options = {}; ///< in the order of the declaration; missing ones are 0
};

/// The variant that these arguments choose; only their options are looked at.
template <class Args> KernelSpec kernel_variant(const Args& args, std::string component) {
  KernelSpec spec{&Args::info(), std::move(component)};
  for (const Field& field : Args::info().fields) {
    if (field.role != Role::option) continue;
    std::uint32_t value = 0;
    std::memcpy(&value, reinterpret_cast<const char*>(&args) + field.offset, sizeof value);
    spec.options.push_back(value);
  }
  return spec;
}

} // namespace pliant
