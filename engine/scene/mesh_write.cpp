// Meshes to files: OBJ and OFF with digits enough to read the same numbers back, PLY and STL in binary.
#include "engine/core/error.h"
#include "engine/scene/mesh.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <bit>
#include <fmt/format.h>
#include <fstream>
#include <iterator>

namespace pliant {
namespace {

/// Little-endian bytes of a number, on any machine.
template <class T> void append(std::string& out, T value) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
  out.append(raw.data(), raw.size());
}

std::string to_text(const Mesh& mesh, bool obj) {
  std::string out = obj ? "" : fmt::format("OFF\n{} {} 0\n", mesh.vertices.size(), mesh.triangles.size());
  const auto to = std::back_inserter(out);
  for (const Vector3& v : mesh.vertices)
    fmt::format_to(to, "{}{} {} {}\n", obj ? "v " : "", v[0], v[1], v[2]);
  const std::uint32_t base = obj ? 1 : 0;
  for (const auto& t : mesh.triangles)
    fmt::format_to(to, "{} {} {} {}\n", obj ? "f" : "3", t[0] + base, t[1] + base, t[2] + base);
  return out;
}

std::string to_ply(const Mesh& mesh) {
  std::string out =
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty "
                  "double y\nproperty double z\nelement face {}\nproperty list uchar uint "
                  "vertex_indices\nend_header\n",
                  mesh.vertices.size(), mesh.triangles.size());
  for (const Vector3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) append(out, v[k]);
  for (const auto& t : mesh.triangles) {
    append(out, std::uint8_t{3});
    for (const std::uint32_t index : t) append(out, index);
  }
  return out;
}

std::string to_stl(const Mesh& mesh) {
  std::string out(80, ' ');
  append(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3 normal = (b - a).cross(c - a).normalized();
    for (const Vector3& v : {normal, a, b, c})
      for (int k = 0; k < 3; ++k) append(out, static_cast<float>(v[k]));
    append(out, std::uint16_t{0});
  }
  return out;
}

} // namespace

void write_mesh(const Mesh& mesh, const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  std::string bytes;
  if (extension == ".obj" || extension == ".off")
    bytes = to_text(mesh, extension == ".obj");
  else if (extension == ".ply")
    bytes = to_ply(mesh);
  else if (extension == ".stl")
    bytes = to_stl(mesh);
  else
    throw Error(ExitCode::input_output,
                fmt::format("{}: meshes are written to .obj, .off, .ply and .stl files", file.string()));
  std::ofstream stream(file, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream)
    throw Error(
        ExitCode::input_output,
        fmt::format("{}: the mesh cannot be written; check the folder and the space left", file.string()));
}

} // namespace pliant
