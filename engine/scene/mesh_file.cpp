// Mesh files by extension; words and numbers of text files; where a mesh of a scene is sought.
#include "engine/scene/mesh_file.h"

#include "engine/core/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <iterator>

namespace pliant {

namespace mesh_file {

void fail_at_line(const Input& input, std::size_t line, const std::string& what) {
  throw Error(ExitCode::usage, fmt::format("{}, line {}: {}", input.path.string(), line, what));
}

void fail_at_byte(const Input& input, std::size_t byte, const std::string& what) {
  throw Error(ExitCode::usage, fmt::format("{}, byte {}: {}", input.path.string(), byte, what));
}

bool Lines::next() {
  words_.clear();
  const std::string_view text = input_.bytes;
  bool joined = false;
  while (at_ < text.size() && (words_.empty() || joined)) {
    const std::size_t newline = std::min(text.find('\n', at_), text.size());
    std::string_view line = text.substr(at_, newline - at_);
    at_ = std::min(newline + 1, text.size());
    ++number_;
    joined = false;
    if (comment_) line = line.substr(0, line.find(comment_));
    for (std::size_t i = 0; i < line.size();) {
      const auto blank = [&](std::size_t k) {
        return line[k] == ' ' || (line[k] >= '\t' && line[k] <= '\r');
      };
      while (i < line.size() && blank(i)) ++i;
      const std::size_t begin = i;
      while (i < line.size() && !blank(i)) ++i;
      if (i > begin) words_.push_back(line.substr(begin, i - begin));
    }
    if (!words_.empty() && words_.back() == "\\") {
      words_.pop_back();
      joined = true;
    }
  }
  return !words_.empty();
}

std::string_view Lines::word_or_fail(std::size_t word, const char* wanted) const {
  if (word >= words_.size()) fail(fmt::format("{} expected, but the line ends", wanted));
  return words_[word];
}

double Lines::real(std::size_t word) const {
  const std::string_view text = word_or_fail(word, "a number");
  const std::optional<double> value = to_real(text);
  if (!value) fail(fmt::format("a number expected, not '{}'", text));
  if (!std::isfinite(*value)) fail(fmt::format("'{}' is not a finite number", text));
  return *value;
}

long long Lines::integer(std::size_t word) const {
  const std::string_view text = word_or_fail(word, "a whole number");
  const std::optional<long long> value = to_integer(text);
  if (!value) fail(fmt::format("a whole number expected, not '{}'", text));
  return *value;
}

Vector3 Lines::vector(std::size_t first) const {
  return {real(first), real(first + 1), real(first + 2)};
}

std::optional<double> to_real(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return std::nullopt;
  // strtod tells too small (0) from too large (infinity); from_chars does not.
  if (fault == std::errc::result_out_of_range) return std::strtod(std::string(word).c_str(), nullptr);
  return fault == std::errc() ? std::optional(value) : std::nullopt;
}

std::optional<long long> to_integer(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  long long value = 0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || fault != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

void add_fan(Mesh& mesh, std::span<const std::uint32_t> corners) {
  for (std::size_t i = 2; i < corners.size(); ++i)
    mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

} // namespace mesh_file

Mesh read_mesh(const std::filesystem::path& file) {
  using namespace mesh_file;
  const auto fail = [&](const std::string& what) -> void {
    throw Error(ExitCode::usage, fmt::format("{}: {}", file.string(), what));
  };
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  Mesh (*const reader)(const Input&) = extension == ".obj"   ? read_obj
                                       : extension == ".off" ? read_off
                                       : extension == ".ply" ? read_ply
                                       : extension == ".stl" ? read_stl
                                                             : nullptr;
  if (!reader) fail(fmt::format("meshes are read from .obj, .off, .ply and .stl files, not '{}'", extension));
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) fail("there is no such mesh file");
  if (std::filesystem::is_directory(file, ignored)) fail("a folder, not a mesh file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail("the mesh file cannot be opened; check its permissions");
  Input input{file, {}};
  input.bytes.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  if (stream.bad()) fail("the mesh file cannot be read to its end");
  if (input.bytes.empty()) fail("the mesh file is empty");
  Mesh mesh = reader(input);
  if (mesh.vertices.empty()) fail("the mesh has no vertices");
  if (mesh.triangles.empty()) fail("the mesh has no faces: a shape needs a closed surface");
  return mesh;
}

std::vector<std::filesystem::path> mesh_folders(const std::filesystem::path& scene_directory) {
  namespace fs = std::filesystem;
  const auto variable = [](const char* key) {
    const char* value = std::getenv(key);
    return std::string(value ? value : "");
  };
  std::vector<fs::path> places{scene_directory.empty() ? fs::path(".") : scene_directory};
  if (const std::string meshes = variable("PLIANT_MESHES"); !meshes.empty()) places.emplace_back(meshes);
  if (const std::string cache = variable("XDG_CACHE_HOME"); !cache.empty())
    places.push_back(fs::path(cache) / "pliant" / "meshes");
  else if (const std::string home = variable("HOME"); !home.empty())
    places.push_back(fs::path(home) / ".cache" / "pliant" / "meshes");
  return places;
}

std::filesystem::path find_mesh(const std::string& name, const std::filesystem::path& scene_directory) {
  namespace fs = std::filesystem;
  std::vector<fs::path> places = mesh_folders(scene_directory);
  if (fs::path(name).is_absolute()) places = {fs::path(name).parent_path()};
  std::string looked;
  for (const fs::path& place : places) {
    std::error_code ignored;
    const fs::path file = place / name; // an absolute name replaces the place
    if (!name.empty() && fs::is_regular_file(file, ignored)) return file;
    looked += fmt::format("\n  {}", place.string());
  }
  throw Error(ExitCode::usage,
              fmt::format("no mesh '{}' in any of{}\nPut it beside the scene or name its folder in "
                          "PLIANT_MESHES; `examples/main-job.sh --meshes` fetches the example meshes",
                          name, looked));
}

} // namespace pliant
