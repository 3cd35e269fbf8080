// The example scenes of failure: what they show, measured.
#include "engine/scene/scene_parse.h"
#include "engine/solver/saved_state.h"
#include "tests/support/bodies.h"

#include <cstring>
#include <map>

namespace pliant::test {
namespace {

Scene example(const std::string& name, const std::vector<std::string>& settings) {
  return read_scene(std::string(PLIANT_SOURCE_DIR) + "/examples/" + name, settings);
}

/// Sizes of the pieces in which particles hang together by bonds that are whole, largest first.
std::vector<std::size_t> pieces_of(Simulation& simulation, const Model& model) {
  std::vector<std::uint32_t> slices, bonds;
  const auto words = [](const SavedBuffer& buffer) {
    std::vector<std::uint32_t> values(buffer.bytes.size() / 4);
    std::memcpy(values.data(), buffer.bytes.data(), buffer.bytes.size());
    return values;
  };
  for (const SavedBuffer& buffer : simulation.save().buffers) {
    if (buffer.name == "slice_begin") slices = words(buffer);
    if (buffer.name == "bond") bonds = words(buffer);
  }
  std::vector<std::uint32_t> parent(model.count());
  for (std::uint32_t i = 0; i < parent.size(); ++i) parent[i] = i;
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const LawRange& range : model.laws)
    for (std::uint32_t local = 0; local < range.count; ++local) {
      const std::uint32_t slice = range.first_slice + local / slice_width;
      for (std::uint32_t row = slices[slice]; row < slices[slice + 1]; ++row)
        parent[root(bonds[2 * slice_width * row + local % slice_width])] = root(range.first + local);
    }
  std::map<std::uint32_t, std::size_t> sizes;
  for (std::uint32_t i = 0; i < parent.size(); ++i) ++sizes[root(i)];
  std::vector<std::size_t> found;
  for (const auto& [piece, size] : sizes) found.push_back(size);
  std::sort(found.rbegin(), found.rend());
  return found;
}

TEST(FailureExamples, TheClothTearsInTwo) {
  const Scene scene = example("tearing-cloth.toml", {"simulation.spacing=0.03"});
  const Model model = assemble(scene);
  const auto device = open_alone({"openmp_float", "openmp", Precision::single_precision});
  Simulation simulation(*device, scene, model);
  std::size_t damaged = 0;
  for (int frame = 0; frame < 9; ++frame) {
    for (int k = 0; k < 40; ++k) simulation.step();
    std::size_t now = 0;
    for (const double damage : simulation.damage()) now += damage > 0.02;
    EXPECT_GE(now, damaged) << "damage does not heal";
    damaged = now;
  }
  for (const StepStatistics& row : simulation.take_statistics()) {
    ASSERT_TRUE(std::isfinite(row.kinetic_energy) && std::isfinite(row.elastic_energy));
    EXPECT_GE(row.elastic_energy, 0);
    EXPECT_EQ(row.not_finite, 0u);
    EXPECT_LT(row.largest_speed, 30);
  }
  const std::vector<std::size_t> pieces = pieces_of(simulation, model);
  std::printf("  %zu of %zu particles have lost bonds; pieces of", damaged, model.count());
  for (std::size_t k = 0; k < std::min<std::size_t>(pieces.size(), 8); ++k) std::printf(" %zu", pieces[k]);
  std::printf(" particles\n");
  EXPECT_GT(damaged, model.count() / 50);
  EXPECT_LT(damaged, model.count() / 2) << "it should tear, not crumble";
  ASSERT_GE(pieces.size(), 2u);
  EXPECT_GT(pieces[1], model.count() / 5) << "two pieces";
}

/// Where a crack along x has come to, and in how many strands its damage lies over the last third of the
/// plate.
struct Front {
  double tip = -1;
  std::size_t strands = 0;
};

Front front_of(const Model& model, const std::vector<double>& damage, double limit) {
  Front front;
  std::map<long, std::vector<double>> columns;
  for (std::size_t i = 0; i < model.count(); ++i) {
    if (damage[i] < limit) continue;
    const Vector3& x = model.reference[i];
    const double world = model.bodies[0].origin.x() + x.x();
    front.tip = std::max(front.tip, world);
    columns[std::lround(world / model.spacing)].push_back(x.y());
  }
  for (auto& [column, heights] : columns) {
    if (static_cast<double>(column) * model.spacing < 0.5 * front.tip) continue;
    std::sort(heights.begin(), heights.end());
    std::size_t strands = 1;
    for (std::size_t k = 1; k < heights.size(); ++k)
      strands += heights[k] - heights[k - 1] > 3 * model.spacing;
    front.strands = std::max(front.strands, strands);
  }
  return front;
}

// Reported, not judged: at what speed the crack runs and whether it branches. Judged is that it runs, and no
// faster than the waves along its faces.
TEST(FailureExamples, TheGlassPlateCracks) {
  const Scene scene =
      example("glass-branching.toml",
              {"simulation.spacing=0.00125", "simulation.time_step=2.5e-7", "simulation.horizon=2.1"});
  const Model model = assemble(scene);
  const auto device = open_alone({"openmp_float", "openmp", Precision::single_precision});
  Simulation simulation(*device, scene, model);
  const Material& glass = scene.materials[0];
  const double shear = glass.young / (2 * (1 + glass.poisson));
  const double rayleigh =
      (0.862 + 1.14 * glass.poisson) / (1 + glass.poisson) * std::sqrt(shear / glass.density);
  const double every = 2e-6;
  const int steps = static_cast<int>(std::lround(every / simulation.time_step()));
  double before = 0, fastest = 0, began = -1, ended = 0, start = 0, end = 0;
  Front front;
  for (double t = every; t < scene.simulation.end + every / 2; t += every) {
    for (int k = 0; k < steps; ++k) simulation.step();
    const double last = front.tip;
    front = front_of(model, simulation.damage(), 0.35);
    if (last > 0.001 && front.tip < 0.045) fastest = std::max(fastest, (front.tip - last) / every);
    if (front.tip > 0.002 && began < 0) began = t, start = front.tip;
    if (front.tip < 0.046) ended = t, end = front.tip;
    before = front.tip;
  }
  std::printf("  tip at %.4f m, %zu strands; mean speed %.0f m/s, fastest over 2 us %.0f m/s; Rayleigh waves "
              "%.0f m/s\n",
              before, front.strands, (end - start) / (ended - began), fastest, rayleigh);
  EXPECT_GT(before, 0.01) << "the crack does not run";
  EXPECT_LT((end - start) / (ended - began), rayleigh);
}

} // namespace
} // namespace pliant::test
