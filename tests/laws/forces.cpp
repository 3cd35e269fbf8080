// Forces are the slope of the energy and products the derivative of the forces, for every basis function,
// both dilatations, directions, and two materials in one body.
#include "tests/laws/materials.h"
#include "tests/support/solve_rig.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;

struct Case {
  std::string name;
  Stage stage;
};

Case case_of(const std::string& name, const Material& material) {
  Case made{name, Stage(lattice(4, 3, 4, spacing), spacing, material, 1. / 60)};
  made.stage.scene.solver.method = "newton";
  made.stage.scene.solver.preconditioner = "diagonal";
  made.stage.model.mass.assign(made.stage.model.count(), 1e-30); // products are of the forces alone
  return made;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (int n = 1; n <= largest_power; ++n)
    for (const char* kind : {"A", "B"})
      for (const bool squared : {false, true}) {
        const std::string name = kind + std::to_string(n);
        all.push_back(case_of(name + (squared ? ", mean square" : ", mean"),
                              basis_of(1e5, 0.35, {{name, 1}}, {{name, 1}})));
        all.back().stage.model.stretch[0].squared = squared;
      }
  for (const auto& [name, material] : some_materials(1e5, 0.1)) {
    all.push_back(case_of(name, material));
    Material strong = material;
    strong.poisson = 0.3;
    strong.anisotropy = directions_of({3, 0.5, 1});
    strong.anisotropy.rotate_degrees = 25;
    all.push_back(case_of(name + ", directions", strong));
  }
  // Every other particle is of another material: other basis, modulus, ratio, dilatation.
  Case mixed = case_of("two materials", basis_of(1e5, 0.3, {{"A2", 1}}, {{"A4", 0.5}, {"B1", 0.5}}));
  const Material other = formed("stvk", "exact", 4e5, 0.4);
  mixed.stage.scene.materials.push_back(other);
  mixed.stage.model.constants.push_back(law_constants(other));
  mixed.stage.model.stretch.push_back(stretch_energy(other));
  for (std::size_t i = 1; i < mixed.stage.model.count(); i += 2) mixed.stage.model.material[i] = 1;
  all.push_back(std::move(mixed));
  return all;
}

std::vector<Vector3> deformed(const Model& model, double noise) {
  Matrix3 map;
  map << 1.3, 0.3, 0, -0.1, 0.7, 0.2, 0, 0.1, 1.1;
  std::vector<Vector3> y = random_field(model.count(), 12);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = map * model.position[i] + noise * spacing * y[i];
  return y;
}

TEST(StretchForces, AreTheSlopeOfTheEnergy) {
  const auto device = open_double();
  double worst = 0;
  for (const Case& one : cases()) {
    Simulation simulation(*device, one.stage.scene, one.stage.model);
    const std::vector<Vector3> y = deformed(one.stage.model, 0.1), f = simulation.elastic_forces(y);
    double error = 0;
    for (unsigned trial = 0; trial < 4; ++trial) {
      std::vector<Vector3> d = random_field(y.size(), 40 + trial);
      if (trial > 1) { // one particle alone
        const Vector3 only = d[trial];
        d.assign(y.size(), Vector3::Zero());
        d[11 * trial] = only;
      }
      const double s = 1e-4 * spacing;
      const auto w = [&](double t) { return simulation.elastic_energy(plus(y, t * s, d)); };
      const double slope = (8 * (w(1) - w(-1)) - (w(2) - w(-2))) / (12 * s);
      error = std::max(error, std::abs(slope + inner(f, d)) / (norm_of(f) * norm_of(d)));
    }
    EXPECT_LT(error, 1e-7) << one.name;
    worst = std::max(worst, error);
    // Nothing pushes the body as a whole, and nothing turns it.
    Vector3 total = Vector3::Zero(), torque = Vector3::Zero();
    double size = 0;
    for (std::size_t i = 0; i < y.size(); ++i) total += f[i], torque += y[i].cross(f[i]), size += f[i].norm();
    EXPECT_LT(total.norm() / size, 1e-13) << one.name;
    EXPECT_LT(torque.norm() / size, 1e-13) << one.name;
  }
  expect_below("force + dE/dy, of the force", worst, 1e-7);
}

TEST(StretchForces, ProductsAreTheirDerivative) {
  const auto device = open_double();
  double worst = 0, asymmetry = 0;
  for (const Case& one : cases()) {
    SolveRig rig(*device, one.stage.scene, one.stage.model);
    const std::size_t n = one.stage.model.count();
    const std::vector<Vector3> u = plus(deformed(one.stage.model, 0.1), -1, one.stage.model.position);
    double error = 0;
    for (unsigned trial = 0; trial < 3; ++trial) {
      std::vector<Vector3> p = random_field(n, 30 + trial);
      if (trial == 2) {
        const Vector3 only = p[trial];
        p.assign(n, Vector3::Zero());
        p[17] = only;
      }
      const double s = 2e-4 * spacing;
      const auto f = [&](double t) { return rig.forces(plus(u, t * s, p)); };
      const auto near = plus(f(1), -1, f(-1)), far = plus(f(2), -1, f(-2));
      std::vector<Vector3> wanted(n);
      for (std::size_t i = 0; i < n; ++i) wanted[i] = (8 * near[i] - far[i]) / (12 * s);
      rig.forces(u);
      const std::vector<Vector3> hp = rig.product(p);
      error = std::max(error, norm_of(plus(hp, 1, wanted)) / norm_of(wanted));
      const std::vector<Vector3> q = random_field(n, 50 + trial), hq = rig.product(q);
      asymmetry = std::max(asymmetry, std::abs(inner(p, hq) - inner(q, hp)) / (norm_of(p) * norm_of(hq)));
    }
    EXPECT_LT(error, 1e-7) << one.name;
    worst = std::max(worst, error);
  }
  expect_below("product against differences of the force", worst, 1e-7);
  expect_below("|p.Hq - q.Hp|", asymmetry, 1e-12);
}

// Where the solver asks for a convex model no direction has negative stiffness; the exact one has, crushed.
TEST(StretchForces, ConvexProductsAreNotNegative) {
  const auto device = open_double();
  bool indefinite = false;
  for (const auto& [name, material] : some_materials(1e5, 0.1)) {
    const Case one = case_of(name, material);
    SolveRig rig(*device, one.stage.scene, one.stage.model);
    const std::size_t n = one.stage.model.count();
    std::vector<Vector3> u = random_field(n, 22);
    for (std::size_t i = 0; i < n; ++i) u[i] = 0.2 * spacing * u[i] - 0.5 * one.stage.model.position[i];
    for (const bool convex : {false, true}) {
      rig.convex = convex;
      rig.forces(u);
      std::vector<Vector3> v = random_field(n, 77);
      const std::vector<Vector3> none(n, Vector3::Zero());
      double largest = 0, least = 0;
      for (int k = 0; k < 30; ++k) {
        v = rig.product(plus(none, 1 / norm_of(v), v));
        largest = 1.2 * norm_of(v);
      }
      v = random_field(n, 78);
      for (int k = 0; k < 150; ++k) {
        v = plus(none, 1 / norm_of(v), v);
        const std::vector<Vector3> hv = rig.product(v);
        least = inner(v, hv);
        v = plus(plus(none, largest, v), -1, hv);
      }
      if (convex)
        expect_above(name + ": least stiffness of the convex model, of the largest", least / largest, -1e-9);
      else
        indefinite = indefinite || least / largest < -1e-3;
    }
  }
  EXPECT_TRUE(indefinite) << "crushing made no exact derivative indefinite: the test shows nothing";
}

// Bonds of no length, and torn ones: finite, and of the scale of the stiffness that the energy goes on with.
TEST(StretchForces, ExtremeStatesAreFinite) {
  for (const DeviceChoice& choice : device_choices()) {
    const auto device = open_alone(choice);
    for (const auto& [name, material] : some_materials(1e5, 0.3)) {
      const Case one = case_of(name, material);
      SolveRig rig(*device, one.stage.scene, one.stage.model);
      for (const double factor : {0.0, 1e-6, 0.05, 30.0, 1e4}) {
        std::vector<Vector3> u = one.stage.model.position;
        for (Vector3& v : u) v *= factor - 1;
        const std::vector<Vector3> f = rig.forces(u), p = rig.product(random_field(u.size(), 3));
        for (const std::vector<Vector3>* field : {&f, &p})
          for (const Vector3& v : *field) ASSERT_TRUE(v.allFinite()) << name << " at a stretch of " << factor;
      }
    }
  }
}

} // namespace
} // namespace pliant::test
