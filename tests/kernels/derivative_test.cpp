// The chains of kernels behind Newton's method, on every device against double on the CPU: the derivative's
// product (tangents, products, contacts), and the multilevel preconditioner (coarse_*, precondition). What
// double computes is held to formulas in tests/physics/derivatives.cpp and multilevel.cpp.
#include "engine/plan/plan.h"
#include "tests/support/solve_rig.h"

#include <set>

namespace pliant::test {
namespace {

class Derivative : public testing::TestWithParam<DeviceChoice> {
protected:
  std::unique_ptr<Device> open = open_alone(GetParam());
  /// Of the norm, in roundings.
  double measured(const std::vector<Vector3>& got, const std::vector<Vector3>& wanted) const {
    double size = 0, error = 0;
    for (std::size_t i = 0; i < got.size(); ++i)
      size += wanted[i].squaredNorm(), error += (got[i] - wanted[i]).squaredNorm();
    return std::sqrt(error / size) / GetParam().epsilon();
  }
};

constexpr double spacing = 0.125; // positions are exact in float

std::vector<Vector3> field(std::size_t count, unsigned seed, double size) {
  std::mt19937 random(seed);
  std::vector<Vector3> v(count);
  for (Vector3& one : v) one = (size * random_vector(random)).cast<float>().cast<double>();
  return v;
}

/// Two bodies that touch each other and the floor, 133 particles: no multiple of a group.
struct Touching {
  Scene scene;
  Model model;
  std::vector<Vector3> u;
  Touching(const char* law, double friction) : Touching(material_of(law, 1e6, 0.3), friction) {}
  Touching(const Material& material, double friction) {
    scene.simulation.spacing = spacing;
    scene.simulation.time_step = 1. / 64;
    scene.output.fps = 64;
    scene.contact.friction = friction;
    scene.solver.method = "newton";
    scene.solver.preconditioner = "multilevel";
    scene.materials = {material};
    for (int k = 0; k < 2; ++k) {
      Body body;
      body.name = k ? "upper" : "lower";
      body.material = scene.materials[0].name;
      body.shape.kind = Shape::Kind::box;
      body.shape.size = spacing * (k ? Vector3(3, 3, 3) : Vector3(7, 3, 5));
      body.shape.at = spacing * Vector3(0.25 * k, 1.5 + 2.75 * k, 0);
      scene.bodies.push_back(body);
    }
    Boundary floor;
    floor.shape.kind = Shape::Kind::plane;
    floor.shape.offset = spacing / 4;
    floor.friction = friction;
    scene.boundaries = {floor};
    model = assemble(scene);
    u = field(model.count(), 3, 0.03 * spacing);
  }
};

TEST_P(Derivative, Products) {
  const auto host = open_double();
  for (const char* law : {"corotated", "ordinary", "neo-hookean"})
    for (const double friction : {0.0, 0.5}) {
      const Touching world(law, friction);
      SolveRig rig(*open, world.scene, world.model), exact(*host, world.scene, world.model);
      rig.forces(world.u), exact.forces(world.u);
      const std::vector<Vector3> p = field(world.model.count(), 4, 0.01);
      // Sums of some 30 bonds, each of differences of places of ten spacings: 1 seen.
      expect_below(std::string(law) + (friction > 0 ? ", friction" : "") + ": product, roundings",
                   measured(rig.product(p), exact.product(p)), 10);
    }
}

// Law M3: both dilatations, directions.
TEST_P(Derivative, ProductsOverBasisFunctions) {
  const auto host = open_double();
  Material basis = material_of("basis", 1e6, 0.3), square = material_of("stvk", 1e6, 0.3);
  basis.volume_basis = {{"A2", 1}};
  basis.bond_basis = {{"A4", 0.5}, {"B1", 0.5}};
  Material strong = basis;
  strong.anisotropy.given = true;
  strong.anisotropy.strengths = {2, 0.5, 1};
  square.form = "exact";
  for (const Material& material : {basis, strong, square}) {
    const Touching world(material, 0);
    SolveRig rig(*open, world.scene, world.model), exact(*host, world.scene, world.model);
    for (const bool convex : {false, true}) {
      rig.convex = exact.convex = convex;
      rig.forces(world.u), exact.forces(world.u);
      const std::vector<Vector3> p = field(world.model.count(), 4, 0.01);
      // As above, with powers up to the fifth of a stretch; 1.5 seen.
      expect_below(material.law + (material.anisotropy.given ? ", directions" : "") + ": product, roundings",
                   measured(rig.product(p), exact.product(p)), 10);
    }
  }
}

TEST_P(Derivative, Multilevel) {
  const auto host = open_double();
  for (const char* law : {"corotated", "ordinary", "neo-hookean"}) {
    const Touching world(law, 0);
    SolveRig rig(*open, world.scene, world.model), exact(*host, world.scene, world.model);
    rig.forces(world.u), exact.forces(world.u);
    rig.refresh(), exact.refresh();
    const std::vector<Vector3> r = field(world.model.count(), 5, 10);
    // Sums of some hundred terms on each of three levels; 2 seen.
    expect_below(std::string(law) + ": preconditioned, roundings",
                 measured(rig.precondition(r), exact.precondition(r)), 40);
  }
}

// Half of a body turned inside out: the derivative that pushes it back, and the one kept positive.
TEST_P(Derivative, ProductsOfInvertedAndConvexOnes) {
  const auto host = open_double();
  for (const char* law : {"ordinary", "stvk"}) {
    Touching world(law, 0);
    world.scene.materials[0].inversion = "clamp";
    for (std::size_t i = 0; i < world.model.count(); ++i)
      if (world.model.body[i] == 0) world.u[i].x() -= 2 * (world.model.position[i].x() - 0.25 * spacing);
    SolveRig rig(*open, world.scene, world.model), exact(*host, world.scene, world.model);
    rig.convex = exact.convex = true;
    rig.forces(world.u), exact.forces(world.u);
    const std::vector<Vector3> p = field(world.model.count(), 4, 0.01);
    const std::vector<Vector3> wanted = exact.product(p);
    // Mirrored neighbourhoods are decomposed, with angles of a few hundred roundings: 10 seen.
    expect_below(std::string(law) + ", inverted: product, roundings", measured(rig.product(p), wanted), 100);
    world.scene.materials[0].inversion = "none";
    SolveRig without(*host, world.scene, world.model);
    without.convex = true;
    without.forces(world.u);
    expect_above(std::string(law) + ": what the push adds, roundings", measured(without.product(p), wanted),
                 1e4);
  }
}

// The worlds above, by law, run every kernel of these chains: one that is added must come into one of them.
TEST(DerivativeChains, AreWhole) {
  std::set<std::string> run;
  for (const char* law : {"corotated", "ordinary", "neo-hookean", "stvk", "clamped"}) {
    Material material = material_of(law, 1e6, 0.3);
    if (material.law == "clamped") material.law = "ordinary", material.inversion = "clamp";
    const Touching world(material, 0.5);
    const Plan plan = make_plan(world.scene, world.model, slice_bonds(world.model), {});
    for (const KernelSpec& kernel : plan.kernels) run.insert(kernel.info->name);
  }
  std::size_t count = 0;
  for (const std::string kernel : {
#define PLIANT_KERNEL(name) #name,
#include "kernels/all.inc"
#undef PLIANT_KERNEL
       })
    for (const char* part : {"coarse_", "_tangent", "_product"})
      if (kernel.find(part) != std::string::npos && kernel.rfind("fluid_", 0) != 0) {
        EXPECT_TRUE(run.count(kernel)) << "no scene of this file runs '" << kernel << "'";
        ++count;
      }
  EXPECT_GE(count, 20u);
}

// With the flag down no kernel of a direction writes anything.
TEST_P(Derivative, NothingWithoutADirection) {
  const Touching world("corotated", 0.5);
  SolveRig rig(*open, world.scene, world.model);
  rig.forces(world.u);
  rig.refresh();
  const std::vector<Vector3> r = field(world.model.count(), 5, 10), other = field(world.model.count(), 6, 10);
  const std::vector<Vector3> z = rig.precondition(r), q = rig.product(r);
  open->upload(rig.state().solver, std::vector<double>(SOLVER_ENTRIES, 0.0));
  EXPECT_EQ(rig.product(other), q);
  EXPECT_EQ(rig.precondition(other), z);
}

INSTANTIATE_TEST_SUITE_P(Devices, Derivative, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
