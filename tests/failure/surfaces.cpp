// Surfaces of bodies that break: a triangle whose particles have lost each other is gone from the picture and
// from the file; what is left of a body in two pieces is two pieces of surface, with no triangle stretched
// between them.
#include "engine/io/folder.h"
#include "engine/io/statistics_writer.h"
#include "engine/render/renderer.h"
#include "engine/scene/mesh_refine.h"
#include "engine/scene/scene_parse.h"
#include "engine/scene/shape.h"
#include "engine/solver/frame.h"
#include "tests/program/program.h"
#include "tests/support/bodies.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <map>
#include <set>

namespace pliant::test {
namespace {

/// A bar or a ribbon, 0.4 m long and weak in its middle, drawn apart by its ends; it parts within a fifth of
/// a second.
std::string drawn(bool solid, const std::string& rest = "") {
  std::string text = fmt::format("name = \"drawn\"\n[simulation]\nspacing = 0.02\ngravity = [0, 0, 0]\n"
                                 "time_step = \"1/60\"\nend = 0.4\n[solver]\niterations = 60\n"
                                 "[materials.bread]\nyoung = 1e5\npoisson = 0.25\ncritical_stretch = 1\n"
                                 "[materials.crumb]\nyoung = 1e5\npoisson = 0.25\ncritical_stretch = 0.1\n"
                                 "[[body]]\nname = \"loaf\"\nmaterial = \"bread\"\nshape = {{ {} }}\n{}\n"
                                 "[[body.region]]\nregion = {{ box = [0.02, 1, 1], at = [0.01, 0, 0] }}\n"
                                 "material = \"crumb\"\n",
                                 solid ? "box = [0.4, 0.08, 0.08]" : "sheet = [0.4, 0.08]",
                                 solid ? "" : "thickness = 0.001");
  for (const int side : {-1, 1})
    text += fmt::format(
        "[[body.moved]]\nregion = {{ box = [0.08, 1, 1], at = [{}, 0, 0] }}\nvelocity = [{}, 0, 0]\n",
        0.2 * side, 0.4 * side);
  return text +
         "[output]\nfps = 30\nfields = [\"damage\"]\ncheckpoint_every = 2\n"
         "[render]\nsize = [160, 120]\ncolor = \"damage\"\nrange = [0, 1]\n"
         "camera = { eye = [0, 0.2, 1.2], look = [0, 0, 0] }\n" +
         rest;
}

/// Labels the triangles left by the pieces in which they hang together; returns the sizes of the pieces.
std::vector<std::size_t> pieces_of(const Mesh& mesh, const std::vector<std::uint32_t>& torn) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  for (std::uint32_t v = 0; v < parent.size(); ++v) parent[v] = v;
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (torn[t] == 0)
      for (int k = 1; k < 3; ++k) parent[root(mesh.triangles[t][k])] = root(mesh.triangles[t][0]);
  std::map<std::uint32_t, std::size_t> sizes;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (torn[t] == 0) ++sizes[root(mesh.triangles[t][0])];
  std::vector<std::size_t> found;
  for (const auto& [piece, size] : sizes) found.push_back(size);
  std::sort(found.rbegin(), found.rend());
  return found;
}

class TornSurfaces : public OnEachDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, TornSurfaces, testing::ValuesIn(device_choices()), ChoiceName());

TEST_P(TornSurfaces, ABodyInTwoHasTwoPiecesOfSurface) {
  for (const bool solid : {true, false}) {
    if (!solid && GetParam().gl()) continue; // software renders slowly
    const Scene scene = parse_scene(drawn(solid), "drawn.toml");
    const Model model = assemble(scene);
    const Mesh& mesh = *model.bodies[0].surface;
    const auto open = device();
    PlanRequest request;
    request.frames = true;
    request.fields = {"damage"};
    Simulation simulation(*open, scene, model, request);
    FrameOutput& frame = *simulation.frame();
    frame.update();
    std::vector<std::uint32_t> torn = open->download_uint(frame.torn());
    EXPECT_EQ(std::count(torn.begin(), torn.end(), 0u), static_cast<long>(mesh.triangles.size()))
        << "at rest";
    for (int k = 0; k < 24; ++k) simulation.step();
    frame.update();
    torn = open->download_uint(frame.torn());
    const std::vector<Real4<double>> vertex = open->download_real4(frame.vertex());
    const auto gone = std::count(torn.begin(), torn.end(), 1u);
    const std::vector<std::size_t> pieces = pieces_of(mesh, torn);
    double longest = 0, longest_gone = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const auto &a = vertex[mesh.triangles[t][k]], &b = vertex[mesh.triangles[t][(k + 1) % 3]];
        double& most = torn[t] != 0 ? longest_gone : longest;
        most = std::max(most, Vector3(a.x - b.x, a.y - b.y, a.z - b.z).norm());
      }
    std::printf("  %s: %ld of %zu triangles gone, longest edge left %.4f m, of those gone %.4f m; pieces of",
                solid ? "bar" : "ribbon", static_cast<long>(gone), torn.size(), longest, longest_gone);
    for (const std::size_t size : pieces) std::printf(" %zu", size);
    std::printf("\n");
    ASSERT_GE(pieces.size(), 2u);
    EXPECT_GT(pieces[1], torn.size() / 5) << "two halves";
    EXPECT_LT(gone, static_cast<long>(torn.size() / 4));
    EXPECT_LT(longest, 2.5 * 0.02) << "a triangle is stretched between the halves";
    EXPECT_GT(longest_gone, 5 * 0.02);
  }
}

// The picture of the gap is that of no body at all; without the marks triangles are drawn across it.
TEST_P(TornSurfaces, AreNotDrawnAcrossTheGap) {
  const Scene scene = parse_scene(drawn(true), "drawn.toml");
  const Model model = assemble(scene);
  const auto open = device();
  PlanRequest request;
  request.frames = true;
  Simulation simulation(*open, scene, model, request);
  for (int k = 0; k < 24; ++k) simulation.step();
  FrameOutput& frame = *simulation.frame();
  frame.update();
  std::unique_ptr<Renderer> renderer;
  try {
    renderer = make_renderer(*open, scene, model, "damage");
  } catch (const Error& error) {
    GTEST_SKIP() << error.what();
  }
  const auto draw = [&](const BufferStorage* torn) {
    return renderer->draw(*open, {frame.particle(), frame.vertex(), 0, torn});
  };
  const Image whole = draw(nullptr), parted = draw(frame.torn());
  std::size_t differ = 0;
  for (unsigned y = 0; y < whole.height; ++y)
    for (unsigned x = 0; x < whole.width; ++x) differ += std::memcmp(whole.at(x, y), parted.at(x, y), 3) != 0;
  EXPECT_GT(differ, whole.width * whole.height / 100) << "the marks change the picture";
  Buffer all = open->allocate("all", Type::uint, model.bodies[0].surface->triangles.size());
  open->upload(all, std::vector<std::uint32_t>(all->count(), 1));
  const Image none = draw(all);
  std::size_t same = 0, seen = 0; // of the columns in the middle
  for (unsigned y = whole.height / 4; y < whole.height / 2; ++y)
    for (unsigned x = 78; x < 82; ++x) {
      ++seen;
      const auto near = [&](const Image& a) {
        int off = 0;
        for (int c = 0; c < 3; ++c) off = std::max(off, std::abs(int(a.at(x, y)[c]) - int(none.at(x, y)[c])));
        return off < 24; // shadows of the halves
      };
      same += near(parted);
    }
  EXPECT_EQ(same, seen);
  const Image again = draw(frame.torn());
  EXPECT_EQ(std::memcmp(again.at(0, 0), parted.at(0, 0), std::size_t{3} * whole.width * whole.height), 0);
}

nlohmann::json record_of(const std::filesystem::path& run) {
  return nlohmann::json::parse(text_of(run / "run.json"));
}

// Files of a run that tears, killed and resumed: as whole as those of one that was not, and the same to the
// bit.
TEST(TornFiles, AreWholeAndGoOnAfterAResume) {
  const Folder folder;
  for (const bool solid : {true, false}) {
    const std::string scene = folder.write("drawn.toml", drawn(solid));
    const auto run = [&](const std::string& out, const std::vector<std::string>& more) {
      std::vector<std::string> words{"run",       scene,    "--out",       (folder / out).string(),
                                     "--backend", "openmp", "--no-render", "--progress",
                                     "none"};
      words.insert(words.end(), more.begin(), more.end());
      const Outcome outcome = pliant(folder, words);
      EXPECT_EQ(outcome.code, 0) << outcome.err;
    };
    const std::string whole = solid ? "bar" : "ribbon", parts = solid ? "bar-parts" : whole;
    run(whole, {});
    if (solid) {
      run(parts, {"--frames", "5"});
      run(parts, {"--resume"});
    }
    EXPECT_EQ(record_of(folder / whole)["hash"], record_of(folder / parts)["hash"]);
    const std::vector<StatisticsRow> rows = read_statistics(folder / whole / "statistics.csv"),
                                     again = read_statistics(folder / parts / "statistics.csv");
    ASSERT_EQ(rows.size(), again.size());
    std::array<double, 2> last{0, 0};
    for (std::size_t k = 0; k < rows.size(); ++k) {
      ASSERT_TRUE(rows[k].fracture && again[k].fracture);
      EXPECT_EQ(*rows[k].fracture, *again[k].fracture) << "step " << rows[k].step;
      EXPECT_GE((*rows[k].fracture)[0], last[0]) << "bonds do not heal";
      last = *rows[k].fracture;
    }
    EXPECT_GT(last[0], 10);
    EXPECT_GT(last[1], 0);
    for (const std::string& out : std::set<std::string>{whole, parts}) {
      const std::string command = fmt::format("/usr/bin/python3 {}/tests/readers/check_run.py '{}' 13",
                                              PLIANT_SOURCE_DIR, (folder / out).string());
      EXPECT_EQ(std::system(command.c_str()), 0);
    }
    // What is left of the triangles, frame by frame.
    const std::string count = fmt::format(
        "/usr/bin/python3 -c \"import h5py, sys; f = h5py.File(sys.argv[1]); "
        "n = [len(f['frames'][k]['loaf_surface']['corners']) // 3 for k in sorted(f['frames'])]; print(n); "
        "sys.exit(not (n == sorted(n, reverse=True) and n[-1] < n[0]))\" '{}'",
        (folder / whole / "run.vtkhdf").string());
    EXPECT_EQ(std::system(count.c_str()), 0) << "triangles are gone for good";
  }
}

// Surfaces of bodies that break are fine enough to tear between particles; of others they stay as they are.
TEST(TornMeshes, AreAsFineAsTheParticles) {
  const Mesh coarse = triangulate_box({1, 0.4, 0.3}, {1, 1, 1});
  const Mesh fine = refine(coarse, 0.11);
  const MeshReport before = examine(coarse), after = examine(fine);
  EXPECT_EQ(after.open_edges, 0u);
  EXPECT_EQ(after.odd_edges, 0u);
  EXPECT_EQ(after.degenerate, 0u);
  EXPECT_NEAR(after.volume, before.volume, 1e-12);
  EXPECT_NEAR(after.area, before.area, 1e-12);
  for (const auto& t : fine.triangles)
    for (int k = 0; k < 3; ++k) EXPECT_LE((fine.vertices[t[k]] - fine.vertices[t[(k + 1) % 3]]).norm(), 0.11);
  EXPECT_EQ(refine(coarse, 2).triangles, coarse.triangles);
  const std::string ball = "[simulation]\nspacing = 0.02\n[materials.m]\nyoung = 1e5\n{}\n[[body]]\n"
                           "material = \"m\"\nshape = {{ sphere = 0.2 }}\n";
  const auto triangles = [&](const std::string& line) {
    return assemble(parse_scene(fmt::format(fmt::runtime(ball), line), "ball.toml"))
        .bodies[0]
        .surface->triangles.size();
  };
  EXPECT_GT(triangles("critical_stretch = 0.1"), triangles(""));
}

} // namespace
} // namespace pliant::test
