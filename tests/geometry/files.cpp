// Mesh files: every format there and back, every kind of bad input once, and where meshes are sought.
#include "tests/geometry/meshes.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <bit>

namespace pliant::test {
namespace {

using testing::HasSubstr;

Mesh odd_sphere() { // positions that no short decimal spells
  Mesh mesh = triangulate_sphere(1.0 / 3, 5);
  for (Vector3& v : mesh.vertices) v += Vector3(0.1, -1e-7, 1e3 / 7);
  return mesh;
}

template <class T> std::string bytes(T value, bool big = false) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (big) std::reverse(raw.begin(), raw.end());
  return {raw.data(), raw.size()};
}

const char* const tetrahedron_off = "3 1 0 2\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
const std::vector<Vector3> tetrahedron{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}};

void expect_tetrahedron(const Mesh& mesh) {
  ASSERT_EQ(mesh.vertices.size(), 4u);
  ASSERT_EQ(mesh.triangles.size(), 4u);
  const MeshReport report = examine(mesh);
  EXPECT_EQ(report.open_edges + report.odd_edges, 0u);
  EXPECT_NEAR(report.volume, 1.0 / 3, 1e-15);
  for (const Vector3& v : tetrahedron)
    EXPECT_NE(std::find(mesh.vertices.begin(), mesh.vertices.end(), v), mesh.vertices.end()) << v.transpose();
}

class RoundTrip : public testing::TestWithParam<const char*> {};

TEST_P(RoundTrip, GivesTheSameMesh) {
  const Folder folder;
  const Mesh mesh = odd_sphere();
  const auto file = folder / (std::string("m") + GetParam());
  write_mesh(mesh, file);
  const Mesh back = read_mesh(file);
  ASSERT_EQ(back.vertices.size(), mesh.vertices.size());
  ASSERT_EQ(back.triangles.size(), mesh.triangles.size());
  // STL stores floats and orders the vertices by first use: compare corner by corner, to a float's rounding.
  const double limit = std::string(GetParam()) == ".stl" ? 1e3 / 7 * 6e-8 : 0;
  double worst = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c)
      worst = std::max(worst, (corners_of(mesh, t)[c] - corners_of(back, t)[c]).cwiseAbs().maxCoeff());
  EXPECT_LE(worst, limit);
}
INSTANTIATE_TEST_SUITE_P(Formats, RoundTrip, testing::Values(".obj", ".off", ".ply", ".stl"));

TEST(ReadMesh, ObjWithPolygonsTexturesNegativeNumbersAndJoinedLines) {
  const Folder folder;
  const Mesh cube =
      read_mesh(save(folder / "cube.OBJ", "# a cube\r\no cube\r\n"
                                          "v 0 0 0\nv 1 0 0 # corner\nv 1 1 0\nv 0 1 0\n"
                                          "v 0 0 1\nv +1 0 1\nv 1 1 1e0\nv 0 1 1 1.0\nvt 0 0\nvn 0 0 1\n"
                                          "f 4/1/1 3/1/1 2/1/1 1/1/1\nf 5//1 6//1 7//1 8//1\nf 1 2 6 5\n"
                                          "f 3/1 4/1 8/1 \\\n7/1\nf -8 -4 -1 -5\nf 2 3 7 6\n"));
  EXPECT_EQ(cube.triangles.size(), 12u);
  const MeshReport report = examine(cube);
  EXPECT_EQ(report.open_edges + report.odd_edges + report.degenerate + report.crossing_pairs, 0u);
  EXPECT_NEAR(report.volume, 1, 1e-15);
  EXPECT_NEAR(report.area, 6, 1e-14);
}

TEST(ReadMesh, OffInItsVariants) {
  const Folder folder;
  const std::string faces = tetrahedron_off;
  expect_tetrahedron(read_mesh(save(folder / "a.off", "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 2\n" + faces)));
  expect_tetrahedron(read_mesh(
      save(folder / "b.off", "# first\nOFF 4 4 0 # here\n\n0 0 0\n1 0 0\n\n0 1 0\n0 0 2\n" + faces)));
  expect_tetrahedron(
      read_mesh(save(folder / "c.off", "COFF\n4 4 0\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n0 1 0 0 0 0 0\n"
                                       "0 0 2 9 9 9 9\n3 1 0 2 0.5 0.5 0.5\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")));
  expect_tetrahedron(read_mesh(save(folder / "d.off", "4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 2\n" + faces)));
}

TEST(ReadMesh, PlyAsTextWithOtherElementsAndOrders) {
  const Folder folder;
  expect_tetrahedron(
      read_mesh(save(folder / "a.ply", "ply\nformat ascii 1.0\ncomment faces come first\nelement face 4\n"
                                       "property uchar red\nproperty list uchar int vertex_index\n"
                                       "element vertex 4\nproperty float z\nproperty double y\n"
                                       "property uchar quality\nproperty short x\nelement edge 1\n"
                                       "property list int float weights\nend_header\n"
                                       "9 3 1 0 2\n9 3 0 1 3\n9 3 1 2 3\n9 3 2 0 3\n"
                                       "0 0 7 0\n0 0 7 1\n0 1 7 0\n2 0 7 0\n2 0.5 0.25\n")));
}

std::string binary_ply(bool big) {
  std::string out =
      std::string("ply\nformat binary_") + (big ? "big" : "little") +
      "_endian 1.0\nelement vertex 4\nproperty int16 y\nproperty float64 x\nproperty uint32 tag\n"
      "property float z\nelement face 4\nproperty list uint16 int8 vertex_indices\nproperty list uchar "
      "float texture\nend_header\n";
  for (const Vector3& v : tetrahedron)
    out += bytes(static_cast<std::int16_t>(v[1]), big) + bytes(v[0], big) + bytes(0xFFFFFFFFu, big) +
           bytes(static_cast<float>(v[2]), big);
  for (const auto& f : {std::array{1, 0, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}) {
    out += bytes(std::uint16_t{3}, big);
    for (const int i : f) out += bytes(static_cast<std::int8_t>(i));
    out += bytes(std::uint8_t{2}) + bytes(0.5f, big) + bytes(0.25f, big);
  }
  return out;
}

TEST(ReadMesh, PlyInBytesOfEitherOrder) {
  const Folder folder;
  expect_tetrahedron(read_mesh(save(folder / "little.ply", binary_ply(false))));
  expect_tetrahedron(read_mesh(save(folder / "big.ply", binary_ply(true))));
}

TEST(ReadMesh, StlMergesEqualCorners) {
  const Folder folder;
  std::string text = "solid four\n", raw = "solid that is binary" + std::string(60, ' ') + bytes(4u);
  for (const auto& f : {std::array{1, 0, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}) {
    text += "facet normal 0 0 0\n outer loop\n";
    raw += std::string(12, '\0');
    for (const int i : f) {
      const Vector3& v = tetrahedron[static_cast<std::size_t>(i)];
      text += "  vertex " + std::to_string(v[0]) + " " + std::to_string(v[1]) +
              (i == 1 ? " -0.0" : " " + std::to_string(v[2])) + "\n";
      for (int k = 0; k < 3; ++k) raw += bytes(static_cast<float>(v[k]));
    }
    text += " endloop\nendfacet\n";
    raw += std::string(2, '\0');
  }
  expect_tetrahedron(read_mesh(save(folder / "text.stl", text + "endsolid four\n")));
  expect_tetrahedron(read_mesh(save(folder / "raw.stl", raw)));
  EXPECT_THAT(
      error_of(ExitCode::usage, [&] { read_mesh(save(folder / "cut.stl", raw.substr(0, raw.size() - 1))); }),
      HasSubstr("line 1"));
  raw[0] = 'x';
  EXPECT_THAT(
      error_of(ExitCode::usage, [&] { read_mesh(save(folder / "cut.stl", raw.substr(0, raw.size() - 1))); }),
      HasSubstr("byte 283: the file ends after 3 of 4 triangles"));
}

struct Bad {
  const char *file, *text, *message;
};

class BadMesh : public testing::TestWithParam<Bad> {};

TEST_P(BadMesh, IsNamedWithItsPlace) {
  const Folder folder;
  const auto file = save(folder / GetParam().file, GetParam().text);
  const std::string message = error_of(ExitCode::usage, [&] { read_mesh(file); });
  EXPECT_THAT(message, HasSubstr(file.string()));
  EXPECT_THAT(message, HasSubstr(GetParam().message));
}

#define PLY "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define PLY_FACE PLY "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
INSTANTIATE_TEST_SUITE_P(
    All, BadMesh,
    testing::Values(
        Bad{"empty.obj", "", "empty"}, Bad{"blank.off", "# nothing\n", "line 1"}, Bad{"m.xyz", "1", ".xyz"},
        Bad{"m.obj", "v 0 0 0\nv 1 0 zero\n", "line 2: a number expected, not 'zero'"},
        Bad{"m.obj", "v 0 0\n", "line 1: a number expected, but the line ends"},
        Bad{"m.obj", "v 0 0 0\nv 0 nan 0\n", "line 2: 'nan' is not a finite number"},
        Bad{"m.obj", "v 0 1e999 0\n", "line 1: '1e999' is not a finite number"},
        Bad{"m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: vertex 4 does not exist"},
        Bad{"m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4: vertex 0 does not exist"},
        Bad{"m.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3: a face of 2 corners"},
        Bad{"m.obj", "v 0 0 0\nf 1/2x/ a b\n", "line 2: a vertex number expected, not 'a'"},
        Bad{"m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no faces"}, Bad{"m.obj", "o nothing\n", "no vertices"},
        Bad{"m.off", "PLY\n", "line 1: OFF expected"}, Bad{"m.off", "4OFF\n1 1 1\n", "line 1: 4OFF"},
        Bad{"m.off", "OFF BINARY\n", "line 1: binary OFF"},
        Bad{"m.off", "OFF\n", "line 1: the file ends before"}, Bad{"m.off", "OFF\n3 -1 0\n", "line 2"},
        Bad{"m.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", "line 4: the file ends after 2 of 3 vertices"},
        Bad{"m.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            "line 6: the file ends after 1 of 2 faces"},
        Bad{"m.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "line 6: vertex 3 does not exist"},
        Bad{"m.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n", "line 6: a whole number expected"},
        Bad{"m.off", "OFF\n3 1 0\n0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n", "line 4: 'inf'"},
        Bad{"m.ply", "plywood\n", "line 1"}, Bad{"m.ply", "ply\nformat ascii 1.0\n", "before 'end_header'"},
        Bad{"m.ply", "ply\nformat utf8 1.0\n", "line 2: 'utf8' is no format"},
        Bad{"m.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n",
            "line 4: 'half' is no type"},
        Bad{"m.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
            "lack x, y or z"},
        Bad{"m.ply", PLY_FACE "0 0 0 1 0 0 0 1", "line 10: the file ends in the 3 elements 'vertex'"},
        Bad{"m.ply", PLY_FACE "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n",
            "line 11: z of vertex 1 is not a finite number"},
        Bad{"m.ply", PLY_FACE "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
            "line 13: vertex -1 of face 0 does not exist"},
        Bad{"m.ply", PLY_FACE "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "line 13: face 0 has 2 corners"},
        Bad{"m.ply",
            PLY "element face 9000000000\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 "
                "1 0\n",
            "9000000000 elements 'face' announced"},
        Bad{"m.stl", "solid a\nfacet\nvertex 0 0 0\nendfacet\nendsolid\n", "line 4: a facet of 1 vertices"},
        Bad{"m.stl", "solid a\nfacet\nvertex 0 0 inf\n", "line 3: 'inf'"},
        Bad{"m.stl", "solid a\n", "before 'endsolid'"},
        Bad{"m.stl", "solid a\nsquare\n", "line 2: 'square' is no word of STL"},
        Bad{"m.stl", "xy", "byte 2"}));

TEST(ReadMesh, BinaryPlyCutShortOrWithBadValues) {
  const Folder folder;
  const std::string good = binary_ply(false);
  EXPECT_THAT(
      error_of(ExitCode::usage, [&] { read_mesh(save(folder / "a.ply", good.substr(0, good.size() - 1))); }),
      HasSubstr("byte " + std::to_string(good.size() - 4) + ": the file ends in the 4 elements 'face'"));
  std::string infinite = good;
  const std::size_t x = good.find("end_header\n") + 11 + 2;
  infinite.replace(x, 8, bytes(std::numeric_limits<double>::infinity()));
  EXPECT_THAT(error_of(ExitCode::usage, [&] { read_mesh(save(folder / "b.ply", infinite)); }),
              HasSubstr("x of vertex 0 is not a finite number"));
}

TEST(ReadMesh, MissingFilesAndFolders) {
  const Folder folder;
  EXPECT_THAT(error_of(ExitCode::usage, [&] { read_mesh(folder / "none.off"); }),
              HasSubstr("no such mesh file"));
  std::filesystem::create_directory(folder / "d.off");
  EXPECT_THAT(error_of(ExitCode::usage, [&] { read_mesh(folder / "d.off"); }), HasSubstr("a folder"));
}

TEST(WriteMesh, SaysWhatItCannotDo) {
  const Folder folder;
  EXPECT_THAT(error_of(ExitCode::input_output, [&] { write_mesh(odd_sphere(), folder / "m.vtk"); }),
              HasSubstr(".obj"));
  EXPECT_THAT(error_of(ExitCode::input_output, [&] { write_mesh(odd_sphere(), folder / "none" / "m.off"); }),
              HasSubstr("cannot be written"));
}

/// Sets a variable of the environment for a while; null takes it away.
class Variable {
public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    value ? setenv(name, value, 1) : unsetenv(name);
  }
  ~Variable() { old_ ? setenv(name_, old_->c_str(), 1) : unsetenv(name_); }
  Variable(const Variable&) = delete;

private:
  const char* name_;
  std::optional<std::string> old_;
};

TEST(FindMesh, LooksBesideTheSceneThenInTheVariableThenInTheCache) {
  const Folder folder;
  const auto scene = folder / "scene", meshes = folder / "meshes",
             cache = folder / "cache" / "pliant" / "meshes";
  for (const auto& place : {scene, meshes, cache}) {
    std::filesystem::create_directories(place);
    save(place / "m.off", "x");
  }
  const Variable variable("PLIANT_MESHES", meshes.c_str()),
      home("XDG_CACHE_HOME", (folder / "cache").c_str());
  EXPECT_EQ(find_mesh("m.off", scene), scene / "m.off");
  std::filesystem::remove(scene / "m.off");
  EXPECT_EQ(find_mesh("m.off", scene), meshes / "m.off");
  std::filesystem::remove(meshes / "m.off");
  EXPECT_EQ(find_mesh("m.off", scene), cache / "m.off");
  EXPECT_EQ(find_mesh((cache / "m.off").string(), scene), cache / "m.off");
  std::filesystem::remove(cache / "m.off");
  const std::string message = error_of(ExitCode::usage, [&] { find_mesh("m.off", scene); });
  for (const auto& place : {scene, meshes, cache}) EXPECT_THAT(message, HasSubstr(place.string()));
  EXPECT_THAT(message, HasSubstr("examples/main-job.sh --meshes"));
}

TEST(FindMesh, TakesTheHomeFoldersCacheByDefault) {
  const Folder folder;
  const auto cache = folder / ".cache" / "pliant" / "meshes";
  std::filesystem::create_directories(cache);
  save(cache / "m.off", "x");
  const Variable variable("PLIANT_MESHES", nullptr), xdg("XDG_CACHE_HOME", nullptr),
      home("HOME", folder.path().c_str());
  EXPECT_EQ(find_mesh("m.off", ""), cache / "m.off");
}

} // namespace
} // namespace pliant::test
