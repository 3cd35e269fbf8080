// What the readers of mesh files share: the bytes, their words line by line, and how to complain about them.
#pragma once

#include "engine/scene/mesh.h"

#include <span>
#include <string_view>

namespace pliant::mesh_file {

struct Input {
  std::filesystem::path path;
  std::string bytes;
};

/// Throws Error(usage): "PATH, line N: WHAT" and "PATH, byte N: WHAT".
[[noreturn]] void fail_at_line(const Input& input, std::size_t line, const std::string& what);
[[noreturn]] void fail_at_byte(const Input& input, std::size_t byte, const std::string& what);

/// Walks the lines that hold words; comments are cut off, a backslash joins a line to the next.
class Lines {
public:
  explicit Lines(const Input& input, char comment = '#') : input_(input), comment_(comment) {}
  /// Goes to the next line with words; false at the end of the file.
  bool next();
  std::size_t number() const { return number_; } ///< of the present line, from 1
  std::size_t end() const { return at_; }        ///< first byte behind the present line
  const std::vector<std::string_view>& words() const { return words_; }
  [[noreturn]] void fail(const std::string& what) const { fail_at_line(input_, number_, what); }
  /// The word as a finite number, or as a whole number; throws where it is missing or is none.
  double real(std::size_t word) const;
  long long integer(std::size_t word) const;
  /// Three finite numbers from `first` on.
  Vector3 vector(std::size_t first) const;

private:
  std::string_view word_or_fail(std::size_t word, const char* wanted) const;

  const Input& input_;
  char comment_;
  std::size_t at_ = 0, number_ = 0;
  std::vector<std::string_view> words_;
};

/// The number that a whole word spells; nothing where it spells none. "nan" and "inf" are numbers here.
std::optional<double> to_real(std::string_view word);
std::optional<long long> to_integer(std::string_view word);

/// A polygon as a fan from its first corner.
void add_fan(Mesh& mesh, std::span<const std::uint32_t> corners);

Mesh read_obj(const Input& input);
Mesh read_off(const Input& input);
Mesh read_ply(const Input& input);
Mesh read_stl(const Input& input);

} // namespace pliant::mesh_file
