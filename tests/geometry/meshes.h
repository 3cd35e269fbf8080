// Meshes and places that the geometry tests share.
#pragma once

#include "engine/core/error.h"
#include "engine/scene/mesh_cross.h"
#include "engine/scene/sample.h"
#include "engine/scene/shape.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <numbers>
#include <random>
#include <unistd.h>

namespace pliant::test {

constexpr double pi = std::numbers::pi;

/// An empty folder of this test, gone with it.
class Folder {
public:
  Folder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() /
            ("pliant-" + std::to_string(getpid()) + "-" + info->test_suite_name() + "-" + info->name());
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

inline std::filesystem::path save(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

/// A mesh of the user's cache; empty where it is not there.
inline std::filesystem::path cached(const std::string& name) {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  const std::filesystem::path base =
      cache && *cache ? std::filesystem::path(cache) : std::filesystem::path(home ? home : ".") / ".cache";
  const std::filesystem::path file = base / "pliant" / "meshes" / name;
  return std::filesystem::exists(file) ? file : std::filesystem::path();
}

/// The message of the Error that `act` throws; its exit code must be `code`.
template <class Act> std::string error_of(ExitCode code, Act&& act) {
  try {
    act();
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code)) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error was thrown";
  return "";
}

class Random {
public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vector3 vector(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }

private:
  std::mt19937 engine_;
};

inline Corners corners_of(const Mesh& mesh, std::size_t t) {
  const auto& i = mesh.triangles[t];
  return {mesh.vertices[i[0]], mesh.vertices[i[1]], mesh.vertices[i[2]]};
}

inline double exact_winding(const Mesh& mesh, const Vector3& point) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) sum += solid_angle(corners_of(mesh, t), point);
  return sum / (4 * pi);
}

/// Both meshes as one, the second moved.
inline Mesh join(const Mesh& a, const Mesh& b, const Vector3& move) {
  Mesh mesh = a;
  for (const Vector3& v : b.vertices) mesh.vertices.push_back(v + move);
  const auto base = static_cast<std::uint32_t>(a.vertices.size());
  for (const auto& t : b.triangles) mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  return mesh;
}

} // namespace pliant::test
