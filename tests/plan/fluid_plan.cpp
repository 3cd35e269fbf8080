// The plan and the truth of fluids.
#include "kernels/fluid_lambda.h"
#include "kernels/fluid_viscosity_begin.h"
#include "kernels/fluid_viscosity_product.h"
#include "tests/plan/truth.h"

#include <algorithm>

namespace pliant::test {
namespace {

class FluidPlanTruth : public PlanTruth {};
INSTANTIATE_TEST_SUITE_P(Devices, FluidPlanTruth, testing::ValuesIn(device_choices()), ChoiceName());

TEST_P(FluidPlanTruth, FluidsAndElasticBodiesShareNothing) {
  for (const bool watched : {false, true})
    for (const bool bounded : {false, true}) {
      PlanScene made = elastic_only();
      Material water;
      water.name = "water";
      water.model = "fluid";
      made.scene.materials = {water};
      made.scene.solver.restore_momentum = true; // an elastic body's
      made.model = assemble_points(lattice_box(4, 4, 5, 0.02), 0.02, 1.87, water, 8e-6);
      made.request.statistics = made.request.divergence = made.request.frames = watched;
      if (bounded) {
        made.scene.boundaries = {floor_below()};
        made.scene.domain = {true, Vector3::Constant(-1), Vector3::Constant(1), {true, false, false}};
      }
      const Truth truth = expect_truth(GetParam(), made, "fluid");
      std::vector<std::string> used{"motion", "neighbours", "density"};
      if (bounded) used.emplace_back("boundaries");
      if (watched) used.insert(used.end(), {"statistics", "divergence", "frames"});
      EXPECT_EQ(truth.plan.used, used);
      for (const char* name : {"slice_begin", "bond", "weight", "shape", "force", "energy", "linear_start",
                               "best_iterate", "inertia_target", "moment"})
        EXPECT_FALSE(truth.plan.find(name)) << name;
      for (const std::string& name : kernels_of(truth.plan)) {
        const bool own = name.rfind("fluid_", 0) == 0 || name.rfind("near_", 0) == 0 ||
                         name.rfind("grid_", 0) == 0 || name.rfind("statistics_", 0) == 0 ||
                         name == "frame_particles";
        EXPECT_TRUE(own) << name;
      }
    }
  for (const BufferSpec& buffer : expect_truth(GetParam(), elastic_only(), "elastic").plan.buffers) {
    EXPECT_NE(buffer.name.rfind("fluid_", 0), 0u) << buffer.name;
    EXPECT_NE(buffer.name.rfind("near_", 0), 0u) << buffer.name;
  }
}

// Of viscosity, redistribution and walls to which fluids stick: what is planned is what runs.
TEST_P(FluidPlanTruth, ForcesOnFluidsAreThoseAskedFor) {
  for (const bool viscous : {false, true})
    for (const char* form : {"", "fickian", "newton"}) {
      PlanScene made = elastic_only();
      Material water;
      water.name = "water";
      water.model = "fluid";
      water.viscosity = viscous ? 1 : 0;
      water.redistribution = *form ? 0.5 : 0;
      water.tensile_strength = viscous ? 1e3 : 0;
      made.scene.materials = {water};
      made.scene.bodies.emplace_back().material = "water";
      if (*form) made.scene.fluid.redistribution_form = form;
      made.model = assemble_points(lattice_box(4, 4, 5, 0.02), 0.02, 1.87, water, 8e-6);
      made.request.statistics = true;
      made.scene.boundaries = {floor_below()};
      made.scene.boundaries[0].slip = false;
      made.scene.domain = {true, {-0.05, -1, -0.05}, {0.15, 1, 0.15}, {false, false, false}};
      const Truth truth = expect_truth(GetParam(), made, "fluid");
      std::vector<std::string> used{"motion", "neighbours", "density", "boundaries"};
      if (viscous) used.insert(used.end(), {"ghosts", "viscosity"});
      if (*form) used.emplace_back("redistribution");
      used.emplace_back("statistics");
      EXPECT_EQ(truth.plan.used, used);
      const std::vector<std::uint32_t> pulls =
          kernel_variant(kernels::fluid_lambda::Args{.walls = 1, .pulls = 1}, "").options;
      EXPECT_EQ(std::any_of(truth.plan.kernels.begin(), truth.plan.kernels.end(),
                            [&](const KernelSpec& kernel) {
                              return kernel.info->name == std::string("fluid_lambda") &&
                                     kernel.options == pulls;
                            }),
                viscous);
    }
}

// Viscosity along lines of centres: scenes without it compile none of it, and with it nothing of the other.
TEST_P(FluidPlanTruth, FormOfViscosityIsTheOneAskedFor) {
  for (const bool central : {false, true}) {
    PlanScene made = elastic_only();
    Material water;
    water.name = "water";
    water.model = "fluid";
    water.viscosity = 1;
    made.scene.materials = {water};
    made.scene.bodies.emplace_back().material = "water";
    if (central) made.scene.fluid.viscosity_form = "central";
    made.model = assemble_points(lattice_box(4, 4, 5, 0.02), 0.02, 1.87, water, 8e-6);
    const Truth truth = expect_truth(GetParam(), made, "fluid");
    std::size_t found = 0;
    for (const KernelSpec& kernel : truth.plan.kernels) {
      const std::string name = kernel.info->name;
      if (name == "fluid_viscosity_begin") {
        EXPECT_EQ(kernel.options,
                  kernel_variant(kernels::fluid_viscosity_begin::Args{.central = central}, "").options);
        ++found;
      } else if (name == "fluid_viscosity_product") {
        EXPECT_EQ(kernel.options,
                  kernel_variant(kernels::fluid_viscosity_product::Args{.central = central}, "").options);
        ++found;
      }
    }
    EXPECT_EQ(found, 2u);
    made.scene.materials[0].viscosity = 0;
    for (const KernelSpec& kernel : expect_truth(GetParam(), made, "fluid").plan.kernels)
      EXPECT_NE(std::string(kernel.info->name).rfind("fluid_viscosity", 0), 0u);
  }
}

// Of bonds between fluid particles, what flows, what redistribution asks of them: what is planned is what
// runs; fluids without have nothing of it.
TEST_P(FluidPlanTruth, BondsOfFluidsAreThoseAskedFor) {
  const auto made_of = [](const char* model, bool flows, bool spread, bool walls) {
    PlanScene made = elastic_only();
    Material clay;
    clay.name = "clay";
    clay.model = model;
    clay.poisson = flows || spread ? 0.3 : 0.25; // at 1/4 bonds do not feel the dilatation
    if (flows) clay.plastic = {true, 10, 0, 0};
    clay.redistribution = spread ? 0.5 : 0;
    made.scene.materials = {clay};
    made.scene.bodies.emplace_back().material = "clay";
    made.scene.solver.tolerance = 0; // all iterations
    made.model = assemble_points(lattice_box(4, 4, 5, 0.02), 0.02, 1.87, clay, 8e-6);
    made.request.statistics = made.request.divergence = walls;
    if (walls) made.scene.boundaries = {floor_below()};
    return made;
  };
  for (const bool flows : {false, true})
    for (const bool spread : {false, true})
      for (const bool walls : {false, true}) {
        PlanScene made = made_of("viscoelastic", flows, spread, walls);
        made.model.velocity[3] = {0.5, 0, 0};
        const Truth truth = expect_truth(GetParam(), made, "viscoelastic");
        std::vector<std::string> used{"motion", "neighbours", "density"};
        if (walls) used.emplace_back("boundaries");
        if (spread) used.emplace_back("redistribution");
        used.insert(used.end(), {"bonds", "elasticity"});
        if (flows) used.emplace_back("plasticity");
        if (walls) used.insert(used.end(), {"statistics", "divergence"});
        EXPECT_EQ(truth.plan.used, used);
        EXPECT_EQ(kernels_of(truth.plan).count("fluid_bond_hold"), spread ? 1u : 0u);
        EXPECT_EQ(kernels_of(truth.plan).count("fluid_bond_flow"), flows || spread ? 1u : 0u);
        EXPECT_EQ(kernels_of(truth.plan).count("fluid_bond_return"), flows || walls ? 1u : 0u);
      }
  for (const bool walls : {false, true}) {
    const Truth truth = expect_truth(GetParam(), made_of("fluid", false, true, walls), "fluid");
    for (const std::string& name : kernels_of(truth.plan)) {
      EXPECT_NE(name.rfind("fluid_bond", 0), 0u) << name;
      EXPECT_NE(name, "chebyshev_step");
    }
    for (const char* name :
         {"near_rest", "near_earlier", "near_place_of", "fluid_displacement", "fluid_before"})
      EXPECT_FALSE(truth.plan.find(name)) << name;
  }
}

// Emitters and sinks bring their own, and of the frame's kernel the variant that knows of particles that are
// not there; fluids without have none of it.
TEST_P(FluidPlanTruth, EmittersAndSinksAddOnlyTheirOwn) {
  const auto made = [](bool emitter, bool sink) {
    PlanScene one = elastic_only();
    Material water;
    water.name = "water";
    water.model = "fluid";
    one.scene.simulation.spacing = 0.02;
    one.scene.materials = {water};
    one.scene.bodies.resize(1);
    one.scene.bodies[0].name = "pool";
    one.scene.bodies[0].material = "water";
    one.scene.bodies[0].shape.size = {0.08, 0.08, 0.1};
    if (emitter) {
      Emitter& tap = one.scene.emitters.emplace_back();
      tap.name = "tap", tap.material = "water";
      tap.disc = 0.03, tap.speed = 1, tap.particles = 50;
      tap.at = {0, 0.2, 0};
    }
    if (sink) one.scene.sinks.emplace_back().region.at = {0, -2, 0};
    one.model = assemble(one.scene);
    one.request.statistics = one.request.divergence = one.request.frames = true;
    return one;
  };
  const Truth plain = expect_truth(GetParam(), made(false, false), "neither");
  for (const std::string& name : variants(plain.plan)) EXPECT_EQ(name.find("gone=1"), std::string::npos);
  for (const char* component : {"emitters", "sinks"})
    EXPECT_EQ(std::count(plain.plan.left_out.begin(), plain.plan.left_out.end(), component), 1);
  const Truth emitting = expect_truth(GetParam(), made(true, false), "emitter"),
              draining = expect_truth(GetParam(), made(false, true), "sink");
  EXPECT_EQ(difference(emitting.allocated, plain.allocated),
            (Names{"emitter_point", "emitter_slot", "emitter_count", "kept_emitter_count"}));
  EXPECT_EQ(difference(draining.allocated, plain.allocated), (Names{"sink", "sunk", "kept_sunk"}));
  EXPECT_EQ(difference(kernels_of(emitting.plan), kernels_of(plain.plan)), Names{"fluid_emit"});
  EXPECT_EQ(difference(kernels_of(draining.plan), kernels_of(plain.plan)), Names{"fluid_sink"});
  EXPECT_TRUE(difference(plain.allocated, emitting.allocated).empty());
  EXPECT_TRUE(difference(plain.allocated, draining.allocated).empty());
}

} // namespace
} // namespace pliant::test
