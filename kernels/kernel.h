// What a kernel is to C++: a name, a group size, and a list of fields with their slots.
//
//   kernels/<name>.decl     the one declaration: options, parameters, tables, buffers
//        |-- <build>/kernels/<name>.h   the same as C++ types, through expand.h:
//        |       Args    what the engine fills in and hands to a device
//        |       View    what a CPU body sees, for float and for double
//        |       info()  what a device needs to run it without knowing it by name
//        `-- the GLSL interface block, which the GL backend writes from info()
//
// A declaration uses the types real, real4, uint and uint4 only: `real` is float in GLSL and float or double
// on the CPU. An option is a number fixed when the shader is compiled; a parameter may change every dispatch;
// a table is a small uniform block; a buffer is a storage block in an explicit slot, at most 8 a variant,
// which is all that OpenGL 4.3 promises: buffers that no variant uses together may share a slot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace pliant {

class BufferStorage; // engine/device/device.h

/// A group of four reals: the vector of this engine. The fourth component is named where it is used.
template <class real> struct alignas(4 * sizeof(real)) Real4 { real x, y, z, w; };
struct alignas(16) Uint4 {
  std::uint32_t x, y, z, w;
};

enum class Type : std::uint8_t { real, real4, uint, uint4 };
enum class Role : std::uint8_t { option, parameter, table, in, out, inout };

/// One line of a declaration.
struct Field {
  const char* name;
  Type type;
  Role role;
  std::uint32_t slot;   ///< storage binding of a buffer, uniform binding of a table
  std::uint32_t size;   ///< elements of a table; 0 for the rest
  std::uint32_t offset; ///< of the value within Args, bytes
};

struct KernelInfo {
  const char* name;
  std::uint32_t group_size;
  std::span<const Field> fields;
};

/// How a value of each type is written in Args: the engine computes in double whatever the device uses.
namespace argument {
using real = double;
using uint = std::uint32_t;
} // namespace argument

/// Every Args begins with this: the number of threads to run, one per particle, bond or vertex.
struct ArgsHeader {
  std::uint32_t threads = 0;
};

} // namespace pliant
