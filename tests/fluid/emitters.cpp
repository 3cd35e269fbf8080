// Emitters and sinks: how much comes, where, how fast; who is taken out; what happens when the scene is full.
#include "engine/solver/guarded_run.h"
#include "engine/solver/saved_state.h"
#include "tests/scene/parse.h"
#include "tests/support/viscoelastic.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace pliant::test {
namespace {

using testing::HasSubstr;

/// A nozzle of 4 x 2 particles of 1 kg whose layers are born every tenth of a second; `more` of the emitter,
/// then of the scene. Steps of 1/64 s, exact in any precision.
Scene tap(const std::string& emitter, const std::string& more = "", const std::string& gravity = "0",
          unsigned capacity = 0) {
  return parsed("[simulation]\nspacing = 0.1\ntime_step = \"1/64\"\ngravity = [0, " + gravity + ", 0]\n" +
                (capacity > 0 ? fmt::format("capacity = {}\n", capacity) : "") +
                "[output]\nfps = 64\n[materials.water]\nmodel = \"fluid\"\n" + more +
                "\n[[emitter]]\nname = \"tap\"\nmaterial = \"water\"\nnozzle = { rectangle = [0.4, 0.2] }\n"
                "at = [0.5, 2, 0.25]\nspeed = 1\n" +
                emitter + "\n");
}

const DeviceChoice on_cpu{"openmp_float", "openmp", Precision::single_precision};

/// With the last good state kept.
PlanRequest watched() {
  PlanRequest request;
  request.divergence = true;
  return request;
}

class Emitters : public OnEachDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, Emitters, testing::ValuesIn(device_choices()), ChoiceName());

// Layers at t = 0, 0.1, 0.2, ...: rate times time, each where it has flown to since, whatever the steps.
TEST_P(Emitters, RateTimesTime) {
  const Scene scene = tap("direction = [1, 0, 0]\nalong = [0, 0, 1]\nparticles = 1000");
  const Model model = assemble(scene);
  EXPECT_EQ(model.count(), 1000u);
  const auto open = device();
  Simulation simulation(*open, scene, model);
  for (int k = 1; k <= 128; ++k) {
    simulation.step();
    const StepStatistics row = simulation.take_statistics().back();
    const auto layers = static_cast<std::size_t>(std::ceil(k / 6.4 - 1e-9));
    ASSERT_EQ(row.emitted, 8 * layers) << "step " << k;
    ASSERT_EQ(row.present, row.emitted);
    ASSERT_EQ(row.removed, 0u);
    // All that lets them leave their lattice is rounding of its density: sums of 32 terms, some steps long.
    ASSERT_LT((row.momentum - Vector3(8.0 * double(layers), 0, 0)).norm(), 1e-4 * 8 * double(layers));
  }
  EXPECT_EQ(simulation.take_statistics().size(), 0u);
  const Points at = simulation.positions();
  double worst = 0;
  for (std::size_t i = 0; i < 160; ++i) {
    const std::size_t layer = i / 8; // of 20 in 2 s
    const Vector3 p = at[i] - Vector3(0.5 + 2 - 0.1 * double(layer), 2, 0.25);
    worst = std::max(worst, std::abs(p.x()) / scene.simulation.spacing);
    EXPECT_NEAR(std::abs(p.y()), 0.05, 1e-4);
    EXPECT_NEAR(std::abs(std::abs(p.z()) - 0.1), 0.05, 1e-4);
  }
  expect_below("place of a layer away from speed times age, spacings", worst, 1e-3);
}

// As far as the horizon a layer goes at the nozzle's speed, from its birth on, not from its step's end: .21
// s, of which the first step has .010625 and 13 more the rest, as it leaves at the nearest end of a step.
// Then it falls.
TEST_P(Emitters, LayersAreHeldAndThenFall) {
  const Scene scene = tap("particles = 8\nstart = 0.005", "", "-10");
  const Model model = assemble(scene);
  const auto open = device();
  Simulation simulation(*open, scene, model);
  const double h = 1. / 64;
  for (int k = 0; k < 30; ++k) {
    simulation.step();
    const double age = (k + 1) * h - 0.005, free = std::max(k - 13, 0);
    const Points at = simulation.positions(), speed = simulation.velocities();
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_NEAR(at[i].y(), 2 - age - 10 * h * h * free * (free + 1) / 2, 2e-6) << k;
      EXPECT_NEAR(speed[i].y(), -1 - 10 * h * free, 2e-6) << k;
    }
  }
}

// A slow nozzle that honey would fall away from: layers that are held keep their lattice while the rope pulls
// at them, bonds know the same of both ends when they are let go, and the rope hangs together.
TEST_P(Emitters, RopesHangFromTheirNozzle) {
  Scene scene = tap("particles = 400", "viscosity = 20000\nredistribution = 1", "-10");
  scene.materials[0].model = "viscoelastic", scene.materials[0].young = 1e4, scene.materials[0].poisson = 0.3;
  scene.materials[0] = yielding(scene.materials[0], 50);
  const Model model = assemble(scene);
  Stage stage(lattice(2, 2, 2, 0.1), 0.1, scene.materials[0], 1. / 64);
  stage.scene = scene;
  const auto open = device();
  Simulation simulation(*open, scene, model);
  std::size_t bonds = 0, held = 0;
  double away = 0;
  for (int k = 0; k < 48; ++k) {
    simulation.step();
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> rest;
    for (const FluidBond& bond : bonds_of(simulation, stage)) rest[{bond.i, bond.j}] = bond.rest;
    for (const auto& [pair, length] : rest) {
      const auto back = rest.find({pair.second, pair.first});
      ASSERT_TRUE(back != rest.end() && back->second == length) << "step " << k;
      ++bonds;
    }
    const double time = (k + 1) / 64.;
    const Points at = simulation.positions(), speed = simulation.velocities();
    for (std::size_t i = 0; i < simulation.fluid()->flow()->emitted(); ++i) {
      const std::size_t layer = i / 8;
      const double age = time - 0.1 * double(layer);
      if (age > 0.2) continue;
      away = std::max({away, std::abs(at[i].y() - (2 - age)), std::abs(speed[i].y() + 1)});
      ++held;
    }
  }
  EXPECT_GT(bonds, 10000u);
  EXPECT_GT(held, 500u);
  expect_below("held layers away from their lattice, m, m/s", away, 1e-5);
  // Layers from top to bottom: none is further from the next than the horizon.
  const Points at = simulation.positions();
  std::vector<double> height;
  for (std::size_t i = 0; i < simulation.fluid()->flow()->emitted(); ++i) height.push_back(at[i].y());
  std::sort(height.begin(), height.end());
  double gap = 0;
  for (std::size_t i = 1; i < height.size(); ++i) gap = std::max(gap, height[i] - height[i - 1]);
  expect_below("largest gap of the rope, spacings", gap / 0.1, 1.2);
}

const std::string pool =
    "[[body]]\nname = \"pool\"\nmaterial = \"water\"\nshape = { box = [1, 0.4, 0.8], at = "
    "[0.5, 0.2, 0.25] }\n[[boundary]]\nshape = { box = [1, 8, 0.8], at = [0.5, 4, 0.25] "
    "}\ninside = true\n";

// A tap runs into a pool whose overflow is taken out: slots are used again, nothing is lost without a count,
// and momentum and mass are those of the particles that are there.
TEST_P(Emitters, SinksMakeRoom) {
  const Scene small =
      tap("when_full = \"stop\"",
          pool + "[[sink]]\nname = \"drain\"\nregion = { box = [1, 0.2, 0.8], at = [0.5, 0.1, "
                 "0.25] }\n",
          "-10", 320 + 64);
  const Model model = assemble(small);
  const auto open = device();
  Simulation simulation(*open, small, model);
  StepStatistics row;
  for (int k = 0; k < 128; ++k) {
    simulation.step();
    row = simulation.take_statistics().back();
    ASSERT_LE(row.present, 384u);
    ASSERT_EQ(row.present + row.sunk, 320 + row.emitted);
    ASSERT_EQ(row.not_finite, 0u);
  }
  EXPECT_EQ(row.emitted, 8u * 20);
  EXPECT_GT(row.sunk, 150u);
  std::size_t there = 0;
  Vector3 momentum = Vector3::Zero();
  const Snapshot end = simulation.snapshot();
  for (std::size_t i = 0; i < end.mass.size(); ++i) {
    there += end.mass[i] > 0;
    momentum += end.mass[i] * end.velocity[i];
    EXPECT_FALSE(end.mass[i] > 0 && end.position[i].y() < 0.2 && i < 320) << "in the sink";
  }
  EXPECT_EQ(there, row.present);
  EXPECT_LT((momentum - row.momentum).norm(), 1e-4 * double(there));
}

/// Full of what was taken out and born again, so that slots come from a read-back.
Scene busy() {
  return tap("when_full = \"stop\"",
             "[domain]\nlow = [-1, 0.9, -1]\nhigh = [2, 3, 1]\nperiodic = [false, false, false]\n[[sink]]\n"
             "region = { plane = [0, 1, 0], offset = 1.5 }\n",
             "-10", 40);
}

TEST_P(Emitters, GoOnInTheSameBits) {
  const Scene scene = busy();
  const Model model = assemble(scene);
  const auto open = device();
  Simulation whole(*open, scene, model, watched()), later(*open, scene, model, watched());
  for (int k = 0; k < 40; ++k) whole.step();
  const SavedState saved = whole.save();
  whole.keep();
  for (int k = 0; k < 40; ++k) whole.step();
  const StepStatistics end = whole.take_statistics().back();
  EXPECT_GT(end.emitted, 80u);
  EXPECT_GT(end.sunk, 40u);
  later.load(saved);
  for (int k = 0; k < 40; ++k) later.step();
  EXPECT_EQ(later.hash(), whole.hash());
  EXPECT_EQ(later.take_statistics().back().emitted, end.emitted);
  const std::string hash = whole.hash();
  whole.rewind();
  for (int k = 0; k < 40; ++k) whole.step();
  EXPECT_EQ(whole.hash(), hash);
  EXPECT_EQ(whole.take_statistics().back().sunk, end.sunk);
}

TEST(Emitter, BitsDoNotDependOnThreads) {
  const Scene scene = busy();
  const Model model = assemble(scene);
  std::string first;
  for (const unsigned threads : {1u, 2u, 3u}) {
    const auto open = open_device({"openmp", Precision::single_precision, threads, false});
    Simulation simulation(*open, scene, model);
    for (int k = 0; k < 80; ++k) simulation.step();
    if (first.empty()) first = simulation.hash();
    EXPECT_EQ(simulation.hash(), first) << threads << " threads";
  }
}

// The CPU in double against each device, over a jet that lands on a floor: before anything is chaotic they
// differ by rounding, which grows a little with each of the contacts.
TEST_P(Emitters, DevicesAgree) {
  const Scene scene =
      tap("particles = 160\ndirection = [0, -1, 0]",
          "viscosity = 20\n[[boundary]]\nshape = { plane = [0, 1, 0], offset = 1.5 }\n", "-10");
  const Model model = assemble(scene);
  const auto run = [&](Device& on) {
    Simulation simulation(on, scene, model);
    for (int k = 0; k < 48; ++k) simulation.step();
    return simulation.positions();
  };
  const auto open = device(), exact = open_alone({"openmp_double", "openmp", Precision::double_precision});
  const Points one = run(*exact), other = run(*open);
  double worst = 0;
  for (std::size_t i = 0; i < one.size(); ++i) worst = std::max(worst, (one[i] - other[i]).norm());
  expect_below("positions apart, spacings", worst / scene.simulation.spacing, 1e-3);
}

// Clay that flows on its way to a sink, and comes again in the same particles: without the bonds and the
// plastic strain of those before.
TEST_P(Emitters, RebornHaveNoPast) {
  Scene scene = busy();
  scene.materials[0] = yielding(viscoelastic(2e4, 0.3), 50);
  scene.materials[0].name = "water";
  const Model model = assemble(scene);
  Stage stage(lattice(2, 2, 2, 0.1), 0.1, scene.materials[0], 1. / 64);
  stage.scene = scene;
  const auto open = device();
  Simulation simulation(*open, scene, model);
  std::vector<double> last(model.count(), 0.0), mass(model.count(), 0.0);
  std::vector<bool> fresh(model.count(), false); // born at the end of the last step
  std::size_t reborn = 0, bonds = 0;
  double before = 0, strain = 0;
  for (int k = 0; k < 100; ++k) {
    simulation.step();
    const std::vector<double> plastic = simulation.plastic_strain();
    const std::vector<double> there = simulation.snapshot().mass;
    for (const FluidBond& bond : bonds_of(simulation, stage))
      if (fresh[bond.i] && fresh[bond.j] && ++bonds > 0)
        strain = std::max(strain, std::abs(bond.y.norm() / bond.rest - 1));
    for (std::size_t i = 0; i < there.size(); ++i) {
      fresh[i] = there[i] > 0 && mass[i] == 0;
      if (there[i] > 0) last[i] = std::max(last[i], fresh[i] ? 0 : plastic[i]);
      if (fresh[i] && k > 30 && ++reborn > 0) before = std::max(before, plastic[i]);
    }
    mass = there;
  }
  EXPECT_GT(reborn, 40u);
  EXPECT_GT(bonds, 100u);
  const double past = *std::max_element(last.begin(), last.end());
  report("largest plastic strain", past);
  EXPECT_GT(past, 0.1);
  EXPECT_EQ(before, 0) << "plastic strain of the newly born";
  expect_below("strain of bonds among the newly born", strain, 0.05);
}

// The whole capacity, then either the run ends before the step that lacks room, with everything up to there,
// or the emitter does.
TEST(Emitter, FullScenesEndItOrTheRun) {
  Scene scene = tap("", "", "0", 100);
  const Model model = assemble(scene);
  EXPECT_EQ(model.count(), 96u) << "whole layers of 8";
  const auto open = open_alone(on_cpu);
  Simulation simulation(*open, scene, model, watched());
  GuardedRun guard(simulation, scene, model, 0);
  std::size_t rows = 0, emitted = 0;
  while (!guard.full() && simulation.steps() < 200) {
    for (const StepStatistics& row : guard.advance(200)) ++rows, emitted = row.emitted;
  }
  ASSERT_TRUE(guard.full());
  EXPECT_EQ(guard.full()->code(), ExitCode::too_large);
  EXPECT_THAT(guard.full()->what(),
              HasSubstr("s.toml:14:10: emitter 'tap': there is no room for its next 8 particles"));
  EXPECT_EQ(emitted, 96u);
  EXPECT_EQ(rows, 76u) << "the 13th layer is born at 1.2 s, in step 77";
  EXPECT_EQ(simulation.steps(), rows);
  scene.emitters[0].stops = true;
  Simulation stopping(*open, scene, model);
  for (int k = 0; k < 100; ++k) stopping.step();
  EXPECT_EQ(stopping.take_statistics().back().present, 96u);
  EXPECT_TRUE(stopping.fluid()->flow()->ended(0));
}

// Steps in parts give birth to the same layers, at the same times.
TEST(Emitter, StepsInParts) {
  const Scene scene = tap("particles = 64");
  const Model model = assemble(scene);
  const auto open = open_alone({"openmp_double", "openmp", Precision::double_precision});
  Simulation whole(*open, scene, model), parts(*open, scene, model);
  for (int k = 0; k < 30; ++k) whole.step(), parts.step_divided(4);
  EXPECT_EQ(parts.take_statistics().back().emitted, 40u);
  const Points one = whole.positions(), other = parts.positions();
  double worst = 0;
  for (std::size_t i = 0; i < one.size(); ++i) worst = std::max(worst, (one[i] - other[i]).norm());
  expect_below("positions apart, spacings", worst / 0.1, 1e-6);
}

// The example, coarse: from when its front, of which hardly anything is inside, has landed, the rope that
// falls and the heap are as dense inside as at rest, within 2 % in the mean of every step.
TEST(Emitter, HoneyKeepsItsDensity) {
  const Scene scene = read_scene(PLIANT_SOURCE_DIR "/examples/honey.toml",
                                 {"simulation.spacing=0.00625", "simulation.capacity=1500"});
  const Model model = assemble(scene);
  const auto open = open_alone(on_cpu);
  Simulation simulation(*open, scene, model);
  double error = 0;
  std::size_t present = 0;
  for (int k = 0; k < 250; ++k) {
    simulation.step();
    for (const StepStatistics& row : simulation.take_statistics()) {
      present = row.present;
      if (row.time > 0.25) error = std::max(error, row.density_error);
    }
  }
  EXPECT_GT(present, 800u);
  expect_below("largest mean |C| inside of a step", error, 0.02);
}

// In a plane scene a nozzle is a line, and what comes out is a metre deep.
TEST_P(Emitters, LinesInAPlane) {
  const Scene scene =
      parsed("[simulation]\nspacing = 0.1\ntime_step = \"1/64\"\ngravity = [0, 0, 0]\ndimension = 2\n"
             "[output]\nfps = 64\n[materials.water]\nmodel = \"fluid\"\n[[emitter]]\n"
             "material = \"water\"\nnozzle = { disc = 0.2 }\ndirection = [0.6, 0.8, 0]\nspeed = 2\n"
             "particles = 30\n");
  const Model model = assemble(scene);
  ASSERT_EQ(model.count(), 30u);
  const auto open = device();
  Simulation simulation(*open, scene, model);
  for (int k = 0; k < 32; ++k) simulation.step();
  const StepStatistics row = simulation.take_statistics().back();
  EXPECT_EQ(row.emitted, 30u) << "seven layers of 4, and 2 of the last";
  EXPECT_LT((row.momentum - 30 * 10 * 2 * Vector3(0.6, 0.8, 0)).norm(), 1e-4 * 600);
  for (const Vector3& p : simulation.positions()) {
    EXPECT_EQ(p.z(), 0);
    EXPECT_NEAR(std::abs(std::abs(p.dot(Vector3(-0.8, 0.6, 0))) - 0.1), 0.05, 1e-4);
  }
  EXPECT_THAT(complaint("[simulation]\nspacing = 0.1\ndimension = 2\n[materials.water]\nmodel = \"fluid\"\n"
                        "[[emitter]]\nmaterial = \"water\"\nnozzle = { disc = 0.2 }\ndirection = [0, 1, 1]\n"
                        "speed = 2\nparticles = 30\n"),
              HasSubstr("s.toml:9:13: emitter.0 with dimension = 2: everything stays in the plane z = 0"));
}

// Two that share a capacity get it in the order of births.
TEST(Emitter, CapacityGoesByBirth) {
  Scene scene = tap("when_full = \"stop\"", "", "0", 70);
  scene.emitters.push_back(scene.emitters[0]);
  Emitter& second = scene.emitters[1];
  second.name = "second", second.at.x() = 5, second.speed = 2, second.start = 0.25;
  second.rectangle.reset(), second.disc = 0.1; // 4 points
  const Model model = assemble(scene);
  // Births: 8 at 0, .1, .2, .3 ...; 4 at .25, .30, ...: by 0.55 s 48 + 24 are due and 70 - 68 = 2 are left.
  EXPECT_EQ(model.bodies[0].count + model.bodies[1].count, 68u);
  const auto open = open_alone(on_cpu);
  Simulation simulation(*open, scene, model);
  for (int k = 0; k < 64; ++k) simulation.step();
  EXPECT_EQ(simulation.take_statistics().back().present, 68u);
}

TEST(Emitter, WrongOnesAreRefused) {
  const std::string simulation = "[simulation]\nspacing = 0.1\ncapacity = 1000\n[materials.water]\nmodel = "
                                 "\"fluid\"\n[materials.rubber]\n";
  const auto with = [&](const std::string& lines, const std::string& more = "") {
    std::string text = "material = \"water\"\nnozzle = { disc = 0.2 }\nspeed = 1\n";
    const std::string key = lines.substr(0, lines.find(' '));
    if (const auto at = text.find(key + " ="); at != std::string::npos)
      text.erase(at, text.find('\n', at) + 1 - at);
    return simulation + "[[emitter]]\n" + lines + "\n" + text + more;
  };
  EXPECT_EQ(complaint(with("at = [0, 1, 0]")), "");
  EXPECT_THAT(complaint(with("material = \"milk\"")),
              HasSubstr("s.toml:8:12: emitter.0.material = 'milk' is not a material of this scene"));
  EXPECT_THAT(complaint(with("material = \"rubber\"")),
              HasSubstr("s.toml:8:12: emitter.0.material = \"rubber\" is elastic: only fluids"));
  EXPECT_THAT(complaint(with("speed = 0")), HasSubstr("s.toml:8:9: emitter.0.speed = 0 is out of range"));
  EXPECT_THAT(complaint(with("nozzle = { disc = 0 }")),
              HasSubstr("s.toml:8:19: emitter.0.nozzle.disc = 0 is out of range"));
  EXPECT_THAT(
      complaint(with("nozzle = { }")),
      HasSubstr("s.toml:8:10: emitter.0.nozzle must have exactly one of disc, rectangle; it has none"));
  EXPECT_THAT(complaint(with("stop = 0.5\nstart = 1")),
              HasSubstr("emitter.0.stop = 0.5 must be after emitter.0.start = 1"));
  EXPECT_THAT(complaint(with("when_full = \"wait\"")), HasSubstr("must be one of \"error\", \"stop\""));
  EXPECT_THAT(complaint(with("along = [0, 1, 0]")), HasSubstr("a disc has none"));
  EXPECT_THAT(complaint("[simulation]\nspacing = 0.1\n[materials.water]\nmodel = \"fluid\"\n[[emitter]]\n"
                        "material = \"water\"\nnozzle = { disc = 0.2 }\nspeed = 1\n"),
              HasSubstr("s.toml:5:1: emitter.0 never ends: say how many particles"));
  EXPECT_THAT(complaint(small_scene + "[[sink]]\nregion = { sphere = 1 }\n"),
              HasSubstr("only fluids run into one"));
  EXPECT_THAT(complaint(with("at = [0, 1, 0]", "[[sink]]\nregion = { mesh = \"a.off\" }\n")),
              HasSubstr("sink.0.region is a box, sphere, cylinder, torus or plane; a mesh"));
  EXPECT_THAT(complaint("[simulation]\nspacing = 0.1\ncapacity = 9\n[materials.rubber]\n[[body]]\nmaterial = "
                        "\"rubber\"\nshape = { sphere = 1 }\n"),
              HasSubstr("s.toml:3:1: simulation.capacity is of fluids"));
  const auto refused = [](const std::string& text) {
    try {
      assemble(parsed(text));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string body =
      "[[body]]\nname = \"pool\"\nmaterial = \"water\"\nshape = { box = [2, 2, 2], at = [0, "
      "-3, 0] }\n";
  EXPECT_THAT(refused(with("at = [0, 1, 0]", body)),
              HasSubstr("s.toml:3:12: simulation.capacity = 1000 is below the 8000 particles"));
  EXPECT_THAT(refused(with("nozzle = { disc = 0.04 }")),
              HasSubstr("s.toml:8:10: emitter 'emitter-0': the nozzle is 0.08 m wide, less than a spacing"));
  EXPECT_THAT(
      refused(with("at = [0, 1, 0]", "[[boundary]]\nname = \"wall\"\nshape = { box = [1, 1, 1], at = "
                                     "[0.5, 1, 0] }\n")),
      HasSubstr("s.toml:10:10: emitter 'emitter-0': the nozzle, or the 0.21 m that it holds its layers, "
                "reaches into obstacle 'wall'"));
  const std::string floor = "[[boundary]]\nname = \"floor\"\nshape = { plane = [0, 1, 0], offset = ";
  EXPECT_THAT(refused(with("at = [0, 1, 0]\ndirection = [0, -1, 0]", floor + "0.8 }\n")),
              HasSubstr("reaches into obstacle 'floor' at (-0.05, 0.79, -0.15) m"));
  EXPECT_EQ(refused(with("at = [0, 1, 0]\ndirection = [0, -1, 0]", floor + "0.78 }\n")), "");
  EXPECT_THAT(refused(with("at = [0, 1, 0]", "[domain]\nlow = [-1, -1, -0.1]\nhigh = [1, 2, 1]\n")),
              HasSubstr("holds its layers, reaches to z = -0.15 m, outside the domain"));
  EXPECT_THAT(refused(with("at = [0, 1, 0]", "[[emitter]]\nname = \"b\"\nmaterial = \"water\"\nat = [0.1, 1, "
                                             "0]\nnozzle = { disc = 0.1 }\nspeed = 1\n")),
              HasSubstr("s.toml:16:10: emitter 'b': the nozzle overlaps that of emitter 'emitter-0'"));
}

} // namespace
} // namespace pliant::test
