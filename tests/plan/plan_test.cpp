// The plan and the truth: what a scene allocates, compiles and runs is what its plan lists, and no more.
#include "tests/plan/truth.h"

#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

INSTANTIATE_TEST_SUITE_P(Devices, PlanTruth, testing::ValuesIn(device_choices()), ChoiceName());

TEST_P(PlanTruth, ElasticOnly) {
  for (const char* law : {"corotated", "ordinary", "projective", "basis", "neo-hookean"}) {
    const Truth truth = expect_truth(GetParam(), elastic_only(law), law);
    EXPECT_EQ(truth.plan.used, (std::vector<std::string>{"motion", "solver", "stationary iteration", "bonds",
                                                         std::string(law) + " elasticity"}));
    for (const BufferSpec& buffer : truth.plan.buffers) {
      const auto& used = truth.plan.used;
      EXPECT_NE(std::find(used.begin(), used.end(), buffer.component), used.end()) << buffer.name;
    }
  }
}

// Only materials that ask to be pushed out of inverted states have buffers and kernels for it.
TEST_P(PlanTruth, InversionAddsOnlyItsOwn) {
  for (const char* law : {"ordinary", "basis"})
    for (const char* method : {"chebyshev", "newton"}) {
      PlanScene made = elastic_only(law);
      made.scene.solver.method = method;
      made.scene.solver.preconditioner = "diagonal";
      made.request.statistics = true;
      const Truth plain = expect_truth(GetParam(), made, std::string(law) + ", " + method);
      for (const std::string& name : plain.plan.used) EXPECT_NE(name, "inversion");
      made.scene.materials[0].inversion = "clamp";
      const Truth pushed = expect_truth(GetParam(), made, std::string(law) + ", pushed back, " + method);
      const bool newton = std::string(method) == "newton";
      Names buffers{"inversion", "inversion_shape"}, kernels;
      if (newton) buffers.insert("inverted");
      EXPECT_EQ(difference(pushed.allocated, plain.allocated), buffers);
      EXPECT_TRUE(difference(plain.allocated, pushed.allocated).empty());
      for (const std::string& name : difference(pushed.dispatched, plain.dispatched))
        EXPECT_EQ(name.rfind("inversion_", 0), 0u) << name;
      EXPECT_TRUE(difference(plain.dispatched, pushed.dispatched).empty());
      EXPECT_EQ(difference(pushed.dispatched, plain.dispatched).size(), newton ? 7u : 3u);
    }
}

// Materials that flow bring rest lengths, what led to them, and variants of their law's kernels; elastic ones
// have nothing of it, and the same variants as ever.
TEST_P(PlanTruth, PlasticityAddsOnlyItsOwn) {
  for (const char* method : {"chebyshev", "newton"})
    for (const bool watched : {false, true}) {
      PlanScene made = elastic_only("ordinary");
      made.scene.solver.method = method;
      made.scene.solver.preconditioner = "diagonal";
      made.request.statistics = made.request.divergence = watched;
      const Truth plain = expect_truth(GetParam(), made, method);
      EXPECT_EQ(std::count(plain.plan.left_out.begin(), plain.plan.left_out.end(), "plasticity"), 1);
      for (const std::string& name : plain.dispatched) {
        EXPECT_EQ(name.find("plastic="), name.find("plastic=0")) << name;
        EXPECT_NE(name.rfind("plastic_", 0), 0u) << name;
      }
      made.scene.materials[0].plastic = {true, 1e3, 0.5, 0};
      const Truth flowing = expect_truth(GetParam(), made, std::string("flowing, ") + method);
      Names buffers{"rest", "yield", "flow", "plastic_row"};
      if (watched) buffers.insert({"kept_rest", "kept_flow", "kept_linear_start"});
      EXPECT_EQ(difference(flowing.allocated, plain.allocated), buffers);
      EXPECT_TRUE(difference(plain.allocated, flowing.allocated).empty());
      EXPECT_EQ(difference(Names(flowing.plan.used.begin(), flowing.plan.used.end()),
                           Names(plain.plan.used.begin(), plain.plan.used.end())),
                Names{"plasticity"});
      EXPECT_EQ(flowing.dispatched.size(), plain.dispatched.size() + 3);
    }
}

// Directions cost their strengths, and nothing where there are none; no other law has anything of this one.
TEST_P(PlanTruth, DirectionsAddTheirStrengthsOnly) {
  for (const char* method : {"chebyshev", "newton"}) {
    PlanScene plain = elastic_only("basis"), strong = elastic_only("basis");
    strong.scene.materials[0].anisotropy.given = true;
    strong.scene.materials[0].anisotropy.strengths = {2, 0.5, 1};
    strong.model = assemble_points(lattice_box(4, 4, 5, 0.02), 0.02, 1.87, strong.scene.materials[0], 8e-6);
    strong.model.velocity = plain.model.velocity;
    plain.scene.solver.method = strong.scene.solver.method = method;
    const Truth without = expect_truth(GetParam(), plain, "isotropic"),
                with = expect_truth(GetParam(), strong, "directions");
    EXPECT_EQ(difference(with.allocated, without.allocated), Names{"strength"});
    EXPECT_EQ(difference(without.allocated, with.allocated), Names{});
    EXPECT_EQ(with.plan.used, without.plan.used);
    PlanScene other = elastic_only("ordinary");
    other.scene.solver.method = method;
    const Truth ordinary = expect_truth(GetParam(), other, "ordinary");
    for (const char* name : {"stretch_record", "energies", "strength"})
      EXPECT_FALSE(ordinary.plan.find(name)) << name;
    for (const std::string& name : kernels_of(ordinary.plan))
      EXPECT_NE(name.rfind("stretch_", 0), 0u) << name;
  }
}

// Bonds that cannot break cost nothing; those that can, their own buffers and kernels, and of the laws the
// variants that know of broken bonds.
TEST_P(PlanTruth, FailureAddsOnlyItsOwn) {
  for (const char* law : {"corotated", "ordinary", "basis"})
    for (const char* method : {"chebyshev", "newton"}) {
      PlanScene made = elastic_only(law);
      made.scene.solver.method = method;
      made.scene.solver.preconditioner = "diagonal";
      made.request.statistics = true;
      const auto find = [](const char* component) {
        for (Switch& one : switches())
          if (std::string(one.component) == component) return one.on;
        return std::function<void(PlanScene&)>{};
      };
      find("surfaces")(made);
      made.model.bodies[0].surface->triangles = {{0, 1, 2}, {1, 2, 3}};
      const Truth plain = expect_truth(GetParam(), made, std::string(law) + ", " + method);
      find("failure")(made);
      const Truth breaks = expect_truth(GetParam(), made, std::string(law) + " that breaks, " + method);
      EXPECT_EQ(difference(breaks.allocated, plain.allocated),
                (Names{"toughness", "energy_before", "released", "fracture", "skin_triangle", "torn"}));
      EXPECT_EQ(difference(plain.allocated, breaks.allocated), Names{});
      const BufferSpec *before = plain.plan.find("shape"), *after = breaks.plan.find("shape");
      EXPECT_EQ(after->count, before->count + 2 * made.model.count()) << "share of weights, bonds broken";
      Names own{"bond_break", "bond_release", "fracture_sum", "surface_tear"};
      EXPECT_EQ(difference(kernels_of(breaks.plan), kernels_of(plain.plan)), own);
      for (const std::string& name : variants(plain.plan)) {
        EXPECT_EQ(name.find("failing=1"), std::string::npos) << name;
        if (name.find("failing=0") == std::string::npos) {
          EXPECT_TRUE(variants(breaks.plan).count(name)) << name;
        }
      }
    }
}

TEST_P(PlanTruth, EachComponentAddsOnlyItsOwn) {
  PlanScene framed = elastic_only();
  framed.request.frames = true;
  const Truth plain = expect_truth(GetParam(), elastic_only(), "plain"),
              frames = expect_truth(GetParam(), framed, "frames");
  for (const Switch& one : switches()) {
    PlanScene made = elastic_only();
    one.on(made);
    const Truth truth = expect_truth(GetParam(), made, one.component);
    SCOPED_TRACE(one.component);
    const Truth& base = made.request.frames && std::string(one.component) != "frames" ? frames : plain;
    Names own{one.component};
    if (std::string(one.component) == "statistics") own.insert("energy"); // whose sums are statistics
    if (std::string(one.component) == "surfaces") own.insert("strain");   // the gradient carries vertices
    if (std::string(one.component) == "energy") own.insert("frames");     // the particle's own volume
    EXPECT_EQ(difference(Names(truth.plan.used.begin(), truth.plan.used.end()),
                         Names(base.plan.used.begin(), base.plan.used.end()))
                  .count(one.component),
              1u);
    for (const BufferSpec& buffer : truth.plan.buffers)
      if (!base.allocated.count(buffer.name)) {
        EXPECT_TRUE(own.count(buffer.component)) << buffer.name << " of " << buffer.component;
      }
    for (const KernelSpec& kernel : truth.plan.kernels)
      if (!base.dispatched.count(variant_name(kernel))) {
        // A variant of a kernel that runs anyway stays with its own component.
        EXPECT_TRUE(own.count(kernel.component) || kernels_of(base.plan).count(kernel.info->name))
            << variant_name(kernel);
      }
    EXPECT_TRUE(difference(base.allocated, truth.allocated).empty());
    EXPECT_NE(std::find(base.plan.left_out.begin(), base.plan.left_out.end(), one.component),
              base.plan.left_out.end());
  }
}

// What one method needs, no other allocates, compiles or runs.
TEST_P(PlanTruth, EachMethodOnlyItsOwn) {
  for (const auto& [name, preconditioner] : {std::pair{"jacobi", ""},
                                             {"position", ""},
                                             {"direct", ""},
                                             {"lbfgs", "diagonal"},
                                             {"lbfgs", "multilevel"},
                                             {"newton", "diagonal"},
                                             {"newton", "multilevel"}}) {
    const std::string method = name;
    for (const char* law : {"corotated", "ordinary", "basis"}) {
      PlanScene made = elastic_only(law);
      made.scene.solver.method = method;
      made.scene.solver.preconditioner = *preconditioner ? preconditioner : "auto";
      made.scene.solver.iterations = 12; // past a second search for contacts
      made.scene.solver.fixed_iterations = true;
      made.scene.boundaries = {floor_below()};
      made.scene.contact.self = true;
      const Truth truth = expect_truth(GetParam(), made, method + " " + preconditioner + " " + law);
      const Names used(truth.plan.used.begin(), truth.plan.used.end());
      const bool line_search = method != "jacobi" && method != "position";
      EXPECT_EQ(used.count("stationary iteration"), line_search ? 0u : 1u);
      EXPECT_EQ(used.count("newton"), method == "newton" ? 1u : 0u);
      EXPECT_EQ(used.count("l-bfgs"), method == "lbfgs" ? 1u : 0u);
      EXPECT_EQ(used.count("preconditioner"), std::string(preconditioner) == "multilevel" ? 1u : 0u);
      // The corotated law has its rotations anyway, the ordinary one does without.
      const bool turns = used.count("preconditioner") > 0 && std::string(law) == "basis";
      EXPECT_EQ(used.count("turning bonds"), turns ? 1u : 0u);
    }
  }
}

TEST_P(PlanTruth, EverythingTogether) {
  PlanScene made = elastic_only("projective");
  made.scene.materials[0].inversion = "swap";
  for (const Switch& one : switches()) one.on(made);
  made.request.fields = {"strain", "energy"};
  const Truth truth = expect_truth(GetParam(), made, "everything");
  EXPECT_EQ(truth.plan.left_out, (std::vector<std::string>{"line search",
                                                           "diagonal preconditioner",
                                                           "preconditioner",
                                                           "turning bonds",
                                                           "direct",
                                                           "newton",
                                                           "quasi-newton",
                                                           "l-bfgs",
                                                           "corotated elasticity",
                                                           "ordinary elasticity",
                                                           "basis elasticity",
                                                           "neo-hookean elasticity",
                                                           "inversion",
                                                           "neighbours",
                                                           "density",
                                                           "ghosts",
                                                           "viscosity",
                                                           "redistribution",
                                                           "emitters",
                                                           "sinks",
                                                           "sheets",
                                                           "plane",
                                                           "failure",
                                                           "plasticity"}));
}

// Fluids have no bonds, no solver, no energies; elastic bodies have nothing of fluids.
TEST(Plan, BytesOfALargeBall) {
  std::vector<Vector3> ball;
  constexpr double radius = 18.15; // spacings
  for (int z = -19; z <= 19; ++z)
    for (int y = -19; y <= 19; ++y)
      for (int x = -19; x <= 19; ++x)
        if (Vector3(x, y, z).norm() <= radius) ball.push_back(0.02 * Vector3(x, y, z));
  EXPECT_NEAR(static_cast<double>(ball.size()), 25000, 500);
  for (const auto& [name, points] : {std::pair{"ball", ball}, {"box", lattice_box(30, 30, 30, 0.02)}}) {
    PlanScene made = elastic_only("corotated", points);
    made.scene.solver.restore_momentum = true;
    made.request.statistics = true;
    made.scene.boundaries = {floor_below()};
    const Plan plan = make_plan(made.scene, made.model, slice_bonds(made.model), made.request);
    const double particle = plan.bytes_per_particle(Precision::single_precision),
                 bond = plan.bytes_per_bond(Precision::single_precision);
    std::printf("%s of %zu: %.1f bytes a particle, %.2f a bond\n", name, points.size(), particle, bond);
    EXPECT_LE(particle, 260) << name;
    EXPECT_LE(bond, 20) << name;
    EXPECT_NEAR(particle * static_cast<double>(plan.particles) + bond * static_cast<double>(plan.bonds),
                static_cast<double>(plan.bytes(Precision::single_precision)), 1);
  }
}

TEST(Plan, Text) {
  PlanScene made = elastic_only();
  made.scene.boundaries = {floor_below()};
  const Plan plan = make_plan(made.scene, made.model, slice_bonds(made.model), made.request);
  const std::string text = plan_text(plan, Precision::single_precision);
  for (const char* part :
       {"80 particles", "boundary_contact[meshes=0,potential=0,tangent=0]",
        "chebyshev_step[checked=1,position=0,contacts=1]", "left out: bdf2, held particles",
        "bytes a particle", "bytes a bond", "position", "single precision"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
  EXPECT_EQ(text.find("prescribe"), std::string::npos);
}

TEST(Plan, Json) {
  const PlanScene made = elastic_only();
  const Plan plan = make_plan(made.scene, made.model, slice_bonds(made.model), made.request);
  const nlohmann::json json = plan_json(plan, Precision::double_precision);
  Names keys;
  for (const auto& item : json.items()) keys.insert(item.key());
  EXPECT_EQ(keys, (Names{"components", "kernels", "buffers", "bytes_per_particle", "bytes_per_bond"}));
  EXPECT_EQ(json["components"]["used"], nlohmann::json(plan.used));
  EXPECT_EQ(json["components"]["left_out"], nlohmann::json(plan.left_out));
  EXPECT_EQ(json["kernels"].get<Names>(), kernels_of(plan));
  EXPECT_EQ(json["kernels"].size(), kernels_of(plan).size()) << "each name once";
  double bytes = 0;
  for (const auto& buffer : json["buffers"]) bytes += buffer["bytes"].get<double>();
  EXPECT_EQ(bytes, static_cast<double>(plan.bytes(Precision::double_precision)));
  EXPECT_EQ(json["bytes_per_particle"], plan.bytes_per_particle(Precision::double_precision));
}

} // namespace
} // namespace pliant::test
