// Where the parameters of dispatches live: a uniform buffer used round and round, so that writing the next ones
// never waits for a dispatch that still reads the last ones.
#pragma once

#include "backends/gl/context.h"

#include <array>
#include <cstddef>

namespace pliant::gl {

class ParameterRing {
public:
  /// The context must be current here, in bind() and in release().
  explicit ParameterRing(const Context& context);
  ParameterRing(const ParameterRing&) = delete;
  ParameterRing& operator=(const ParameterRing&) = delete;

  /// Copies `bytes` of parameters in and binds them to a uniform slot.
  void bind(unsigned slot, const void* parameters, std::size_t bytes);
  void release();

private:
  // A segment is written again only after its fence; with four of them the fence has long passed. 128 KiB each
  // hold 512 dispatches at the largest alignment that drivers ask for (256 bytes).
  static constexpr std::size_t segments = 4, segment_bytes = 128 * 1024;

  void next_segment();

  const Context& context_;
  unsigned buffer_ = 0;
  std::byte* mapped_ = nullptr; ///< where the driver has persistent maps (GL_ARB_buffer_storage)
  std::size_t alignment_ = 256, segment_ = 0, used_ = 0;
  std::array<void*, segments> fences_{};
};

} // namespace pliant::gl
