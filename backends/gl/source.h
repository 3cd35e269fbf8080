// From a kernel's declaration to the text that the GLSL compiler gets, and back from its log to file and
// line.
//
//   #version, types, options as numbers
//   parameters (uniform block), tables (uniform blocks), buffers (storage blocks), each in its slot; of
//   tables and buffers only those that the variant uses common/threads.glsl, then <kernel>.comp with its
//   #include lines expanded, each file once
#pragma once

#include "kernels/kernel.h"

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace pliant::gl {

/// File name below shaders/ to text.
using Texts = std::map<std::string, std::string>;

/// Uniform binding of the parameter block; tables use the slots below it.
inline constexpr std::uint32_t parameter_slot = 11;
/// Storage blocks that OpenGL 4.3 promises to a compute shader.
inline constexpr std::uint32_t max_buffers = 8;

/// A whole program text. `files[n]` is what source number n of its #line directives (and of a log) means.
struct Source {
  std::string text;
  std::vector<std::string> files;
  std::set<std::string> names; ///< of a kernel: the tables and buffers that this variant uses
};

/// The text for the options in `args` (an Args of this kernel). Throws Error(internal) for a missing file or
/// a declaration that GLSL cannot express.
Source expand_kernel(const KernelInfo& kernel, const void* args, const Texts& texts);

/// Appends file `name` with its includes expanded, for texts that are no kernels (the renderer's).
void append_file(Source& source, const std::string& name, const Texts& texts);

/// A compiler's log with source numbers replaced by file names: "predict.comp:12(5): error: …".
std::string readable_log(const std::string& log, const Source& source);

/// "predict[bdf2=0]".
std::string variant_name(const KernelInfo& kernel, const void* args);

/// Bytes of the parameter block: `threads`, then each parameter, 4 bytes each.
std::size_t parameter_bytes(const KernelInfo& kernel);

/// The whole text that the compiler gets for the embedded shader of this kernel.
std::string expanded_source(const KernelInfo& kernel, const void* args);

} // namespace pliant::gl
