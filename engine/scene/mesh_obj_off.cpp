// Wavefront OBJ and Geomview OFF: text, a vertex or a face a line.
#include "engine/scene/mesh_file.h"

#include <fmt/format.h>
#include <limits>

namespace pliant::mesh_file {

/// OBJ: `v x y z` and `f a b c ...`, a corner being v, v/vt, v//vn or v/vt/vn, negative where it counts from
/// the latest vertex. Everything else (normals, groups, materials) is of no use here.
Mesh read_obj(const Input& input) {
  Mesh mesh;
  Lines lines(input);
  std::vector<std::uint32_t> corners;
  while (lines.next()) {
    const auto& words = lines.words();
    if (words[0] == "v") {
      mesh.vertices.push_back(lines.vector(1));
    } else if (words[0] == "f") {
      corners.clear();
      const long long count = static_cast<long long>(mesh.vertices.size());
      for (std::size_t w = 1; w < words.size(); ++w) {
        const std::optional<long long> typed = to_integer(words[w].substr(0, words[w].find('/')));
        if (!typed) lines.fail(fmt::format("a vertex number expected, not '{}'", words[w]));
        const long long index = *typed < 0 ? count + *typed : *typed - 1;
        if (index < 0 || index >= count)
          lines.fail(
              fmt::format("vertex {} does not exist: {} vertices come before this line", *typed, count));
        corners.push_back(static_cast<std::uint32_t>(index));
      }
      if (corners.size() < 3) lines.fail(fmt::format("a face of {} corners; it needs 3", corners.size()));
      add_fan(mesh, corners);
    }
  }
  return mesh;
}

/// OFF: an optional word [ST][C][N]OFF, the counts (on its line or on the next), vertices, faces. Colours,
/// normals and texture coordinates behind the numbers that matter are skipped.
Mesh read_off(const Input& input) {
  Mesh mesh;
  Lines lines(input);
  if (!lines.next()) lines.fail("the mesh file has nothing but comments");
  std::size_t word = 0;
  if (!to_integer(lines.words()[0])) {
    const std::string_view kind = lines.words()[0];
    if (kind.size() < 3 || kind.substr(kind.size() - 3) != "OFF")
      lines.fail(fmt::format("OFF expected, not '{}'", kind.substr(0, 40)));
    if (kind.find_first_not_of("STCN") < kind.size() - 3)
      lines.fail(fmt::format(
          "{} has points of other than three dimensions; only OFF, COFF, NOFF and STOFF are read", kind));
    word = 1;
    if (lines.words().size() > 1 && lines.words()[1] == "BINARY")
      lines.fail("binary OFF is not read; save the mesh as text or as PLY");
    if (lines.words().size() == 1) {
      if (!lines.next()) lines.fail("the file ends before the numbers of vertices and faces");
      word = 0;
    }
  }
  const long long vertices = lines.integer(word), faces = lines.integer(word + 1);
  if (vertices < 0 || faces < 0 || vertices > std::numeric_limits<std::uint32_t>::max())
    lines.fail(fmt::format("{} vertices and {} faces: impossible numbers", vertices, faces));
  for (long long i = 0; i < vertices; ++i) {
    if (!lines.next()) lines.fail(fmt::format("the file ends after {} of {} vertices", i, vertices));
    mesh.vertices.push_back(lines.vector(0));
  }
  std::vector<std::uint32_t> corners;
  for (long long i = 0; i < faces; ++i) {
    if (!lines.next()) lines.fail(fmt::format("the file ends after {} of {} faces", i, faces));
    const long long count = lines.integer(0);
    if (count < 3) lines.fail(fmt::format("a face of {} corners; it needs 3", count));
    corners.clear();
    for (long long c = 0; c < count; ++c) {
      const long long index = lines.integer(static_cast<std::size_t>(c) + 1);
      if (index < 0 || index >= vertices)
        lines.fail(fmt::format("vertex {} does not exist: they are numbered 0 to {}", index, vertices - 1));
      corners.push_back(static_cast<std::uint32_t>(index));
    }
    add_fan(mesh, corners);
  }
  return mesh;
}

} // namespace pliant::mesh_file
