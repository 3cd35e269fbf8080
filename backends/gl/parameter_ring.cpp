// The ring of parameter blocks.
#include "backends/gl/parameter_ring.h"

#include "engine/core/error.h"

#include <glad/gl.h>

#include <algorithm>
#include <cstring>

namespace pliant::gl {

ParameterRing::ParameterRing(const Context& context) : context_(context) {
  const GladGLContext& gl = context.gl();
  GLint alignment = 0;
  gl.GetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
  alignment_ = static_cast<std::size_t>(std::max(alignment, 16));
  constexpr GLsizeiptr bytes = segments * segment_bytes;
  gl.GenBuffers(1, &buffer_);
  gl.BindBuffer(GL_UNIFORM_BUFFER, buffer_);
  if (gl.ARB_buffer_storage) {
    constexpr GLbitfield flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    gl.BufferStorage(GL_UNIFORM_BUFFER, bytes, nullptr, flags);
    mapped_ = static_cast<std::byte*>(gl.MapBufferRange(GL_UNIFORM_BUFFER, 0, bytes, flags));
    if (!mapped_) throw Error(ExitCode::internal, "the GL driver does not map its parameter buffer");
  } else {
    gl.BufferData(GL_UNIFORM_BUFFER, bytes, nullptr, GL_DYNAMIC_DRAW);
  }
}

void ParameterRing::next_segment() {
  const GladGLContext& gl = context_.gl();
  fences_[segment_] = gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  segment_ = (segment_ + 1) % segments;
  used_ = 0;
  if (!fences_[segment_]) return;
  const auto fence = static_cast<GLsync>(fences_[segment_]);
  while (gl.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 1'000'000'000) == GL_TIMEOUT_EXPIRED) {
  }
  gl.DeleteSync(fence);
  fences_[segment_] = nullptr;
}

void ParameterRing::bind(unsigned slot, const void* parameters, std::size_t bytes) {
  const GladGLContext& gl = context_.gl();
  const std::size_t whole = (bytes + 15) / 16 * 16; // drivers may round a block up to a group of four
  const std::size_t stride = (whole + alignment_ - 1) / alignment_ * alignment_;
  if (stride > segment_bytes) throw Error(ExitCode::internal, "a kernel has too many parameters");
  if (used_ + stride > segment_bytes) next_segment();
  const std::size_t offset = segment_ * segment_bytes + used_;
  used_ += stride;
  if (mapped_) {
    std::memcpy(mapped_ + offset, parameters, bytes);
  } else {
    gl.BindBuffer(GL_UNIFORM_BUFFER, buffer_);
    void* place = gl.MapBufferRange(GL_UNIFORM_BUFFER, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(whole),
                                    GL_MAP_WRITE_BIT | GL_MAP_UNSYNCHRONIZED_BIT | GL_MAP_INVALIDATE_RANGE_BIT);
    if (!place) throw Error(ExitCode::internal, "the GL driver does not map its parameter buffer");
    std::memcpy(place, parameters, bytes);
    gl.UnmapBuffer(GL_UNIFORM_BUFFER);
  }
  gl.BindBufferRange(GL_UNIFORM_BUFFER, slot, buffer_, static_cast<GLintptr>(offset),
                     static_cast<GLsizeiptr>(whole));
}

void ParameterRing::release() {
  const GladGLContext& gl = context_.gl();
  for (void*& fence : fences_) {
    if (fence) gl.DeleteSync(static_cast<GLsync>(fence));
    fence = nullptr;
  }
  gl.DeleteBuffers(1, &buffer_);
  buffer_ = 0;
}

} // namespace pliant::gl
