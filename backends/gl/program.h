// GL programs: compiled, checked against their declaration, and kept on disk as the driver's binary.
#pragma once

#include "backends/gl/context.h"
#include "backends/gl/source.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace pliant::gl {

/// Owns a linked program of a context; deleted with the context current or not.
class Program {
public:
  /// One stage: its GL enum (GL_COMPUTE_SHADER, …) and its text.
  using Stages = std::vector<std::pair<unsigned, Source>>;

  /// Compiles and links, or takes the binary of an earlier run. `what` names it in messages. Throws
  /// Error(internal) with the compiler's log, file and line.
  Program(Context& context, const std::string& what, const Stages& stages);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  unsigned name() const { return name_; }
  bool from_cache() const { return from_cache_; }

private:
  bool load_binary(const std::string& path);
  void save_binary(const std::string& path) const;
  void compile(const std::string& what, const Stages& stages);

  Context& context_;
  unsigned name_ = 0;
  bool from_cache_ = false;
};

/// The compute program of one variant of a kernel, checked against its declaration.
class KernelProgram {
public:
  KernelProgram(Context& context, const KernelInfo& kernel, const void* args, const Texts& texts);
  unsigned name() const { return program_.name(); }
  bool from_cache() const { return program_.from_cache(); }
  /// Whether this variant uses the table or buffer.
  bool uses(const Field& field) const { return source_.names.count(field.name) > 0; }

private:
  Source source_;
  Program program_;
};

/// Where program binaries lie: $XDG_CACHE_HOME/pliant/programs, ~/.cache by default. Empty when there is no
/// such place or PLIANT_PROGRAM_CACHE=off.
std::string program_cache_folder();

} // namespace pliant::gl
