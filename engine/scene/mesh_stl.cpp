// STL: a soup of triangles as text or as bytes. Corners that are equal to the last bit become one vertex.
#include "engine/scene/mesh_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <unordered_map>

namespace pliant::mesh_file {
namespace {

class Welder {
public:
  explicit Welder(Mesh& mesh) : mesh_(mesh) {}
  std::uint32_t operator()(const Vector3& corner) {
    const Vector3 key = corner + Vector3::Zero(); // -0 becomes 0
    const auto [at, added] =
        index_.try_emplace({key[0], key[1], key[2]}, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (added) mesh_.vertices.push_back(key);
    return at->second;
  }

private:
  using Key = std::array<double, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t mixed = 0;
      for (const double value : key) {
        mixed = (mixed ^ std::bit_cast<std::uint64_t>(value)) * 0x9E3779B97F4A7C15u;
        mixed ^= mixed >> 29;
      }
      return static_cast<std::size_t>(mixed);
    }
  };
  Mesh& mesh_;
  std::unordered_map<Key, std::uint32_t, Hash> index_;
};

template <class T> T little(const std::string& bytes, std::size_t at) {
  static_assert(sizeof(T) == 4);
  std::uint32_t raw = 0;
  for (std::size_t k = 0; k < 4; ++k)
    raw |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + k])) << (8 * k);
  return std::bit_cast<T>(raw);
}

constexpr std::size_t head = 84, record = 50; // bytes of a binary file's head and of each triangle

Mesh read_binary(const Input& input) {
  const std::string& bytes = input.bytes;
  if (bytes.size() < head)
    fail_at_byte(input, bytes.size(), "the file ends in the 84 bytes that a binary STL file begins with");
  const std::size_t count = little<std::uint32_t>(bytes, head - 4);
  if ((bytes.size() - head) / record < count)
    fail_at_byte(
        input, bytes.size(),
        fmt::format("the file ends after {} of {} triangles", (bytes.size() - head) / record, count));
  Mesh mesh;
  Welder weld(mesh);
  for (std::size_t t = 0; t < count; ++t) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = head + record * t + 12 * (c + 1); // the first 12 bytes are the normal
      const Vector3 corner(little<float>(bytes, at), little<float>(bytes, at + 4),
                           little<float>(bytes, at + 8));
      if (!corner.allFinite())
        fail_at_byte(input, at, fmt::format("a corner of triangle {} is not finite", t));
      triangle[c] = weld(corner);
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

Mesh read_text(const Input& input) {
  Mesh mesh;
  Welder weld(mesh);
  Lines lines(input, '\0');
  std::vector<std::uint32_t> corners;
  bool in_solid = false, in_facet = false;
  while (lines.next()) {
    const std::string_view word = lines.words()[0];
    if (word == "solid") {
      in_solid = true;
    } else if (word == "endsolid") {
      if (in_facet) lines.fail("the solid ends within a facet");
      in_solid = false;
    } else if (word == "facet") {
      if (in_facet) lines.fail("a facet within a facet");
      in_facet = true;
      corners.clear();
    } else if (word == "vertex") {
      if (!in_facet) lines.fail("a vertex outside of a facet");
      corners.push_back(weld(lines.vector(1)));
    } else if (word == "endfacet") {
      if (!in_facet || corners.size() != 3)
        lines.fail(fmt::format("a facet of {} vertices; it needs 3", corners.size()));
      add_fan(mesh, corners);
      in_facet = false;
    } else if (word != "outer" && word != "endloop") {
      lines.fail(fmt::format("'{}' is no word of STL", word.substr(0, 40)));
    }
  }
  if (in_solid || in_facet) lines.fail("the file ends before 'endsolid'");
  return mesh;
}

} // namespace

Mesh read_stl(const Input& input) {
  // Binary files may begin with "solid" too: their length tells.
  const std::string& bytes = input.bytes;
  const bool exact =
      bytes.size() >= head && bytes.size() - head == record * little<std::uint32_t>(bytes, head - 4);
  const std::size_t word = bytes.find_first_not_of(" \t\r\n");
  if (!exact && word != std::string::npos && bytes.compare(word, 5, "solid") == 0) return read_text(input);
  return read_binary(input);
}

} // namespace pliant::mesh_file
