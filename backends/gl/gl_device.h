// The OpenGL 4.3 compute device: buffers are storage blocks, kernels are compute shaders named after their
// declaration. It knows no kernel by name.
//
// Each call makes the context current and, where a host's context was, restores that. A host that steps often
// holds `Current current(context_of(device))` over its steps, or hands its own context over.
#pragma once

#include "backends/gl/context.h"
#include "backends/gl/source.h"
#include "engine/device/device.h"

#include <memory>

namespace pliant::gl {

/// The device of describe_all() at `index`. Throws Error(no_device).
std::unique_ptr<Device> make_device(int index);
/// A device on this context. `texts` (default: those of this build) must outlive it.
std::unique_ptr<Device> make_device(std::unique_ptr<Context> context, const Texts* texts = nullptr);

/// True for a GL device, replayed or not.
bool is_gl(Device& device);
/// The context of a GL device, replayed or not. Throws Error(internal) for another device.
Context& context_of(Device& device);
/// The GL buffer that holds this storage from its byte 0. What draws from it calls
/// glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT) or what else fits first: a dispatch is followed by the
/// barriers that kernels and transfers need.
unsigned gl_name(const BufferStorage& buffer);
/// Programs that came from the cache on disk instead of the compiler.
unsigned programs_from_cache(Device& device);

} // namespace pliant::gl
