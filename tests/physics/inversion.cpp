// Resistance to inversion (Xu et al. 2018, Eq. 24, with a potential): it is the gradient of its energy in
// every state, nothing where nothing is inverted, and brings bodies back that laws over bonds alone leave
// inside out.
#include "tests/support/solve_rig.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;

Material pushed(const char* law, double poisson = 0.25, const char* inversion = "clamp") {
  Material made = material_of(law, 1e5, poisson);
  if (made.law == "basis") made.volume_basis = made.bond_basis = {{"A2", 1.0}};
  made.inversion = inversion;
  return made;
}

Points moved(const Points& rest, const Matrix3& map, double noise, unsigned seed) {
  std::mt19937 random(seed);
  Points y;
  for (const Vector3& x : rest) y.push_back(map * x + noise * spacing * random_vector(random));
  return y;
}

TEST(Inversion, ForceIsTheGradientWhereSomethingIsInverted) {
  const auto device = open_double();
  for (const char* law : {"ordinary", "stvk"}) {
    Stage stage(lattice(6, 5, 4, spacing), spacing, pushed(law), 1. / 60);
    Simulation simulation(*device, stage.scene, stage.model);
    Stage bare(lattice(6, 5, 4, spacing), spacing, pushed(law, 0.25, "none"), 1. / 60);
    Simulation without(*device, bare.scene, bare.model);
    const Points rest = simulation.positions();
    const Matrix3 mirrored = Vector3(-0.9, 1.1, 1).asDiagonal(), flat = Vector3(1, 0.03, 1).asDiagonal(),
                  line = Vector3(1, 0.02, -0.03).asDiagonal();
    for (const auto& [name, map] :
         {std::pair{"mirrored", mirrored}, {"nearly flat", flat}, {"nearly a line", line}}) {
      const Points y = moved(rest, map, 0.08, 3);
      const std::vector<Vector3> force = simulation.elastic_forces(y);
      expect_above(std::string(law) + ", " + name + ": share of the push in the force",
                   largest_difference(force, without.elastic_forces(y)) / largest(force), 0.02);
      std::mt19937 random(5);
      double worst = 0;
      for (int trial = 0; trial < 8; ++trial) {
        std::vector<Vector3> d(y.size(), Vector3::Zero());
        if (trial < 4)
          for (Vector3& v : d) v = random_vector(random);
        else
          d[random() % d.size()] = random_vector(random);
        const double s = 1e-5 * spacing;
        const auto energy = [&](double t) { return simulation.elastic_energy(plus(y, t * s, d)); };
        const double slope = (8 * (energy(1) - energy(-1)) - (energy(2) - energy(-2))) / (12 * s);
        worst =
            std::max(worst, std::abs(slope + inner(force, d)) / std::sqrt(inner(force, force) * inner(d, d)));
      }
      expect_below(std::string(law) + ", " + name + ": force against the energy", worst, 1e-7);
      Vector3 sum = Vector3::Zero(), torque = Vector3::Zero();
      double size = 0;
      for (std::size_t i = 0; i < y.size(); ++i) {
        sum += force[i], torque += y[i].cross(force[i]);
        size += force[i].norm();
      }
      expect_below(std::string(law) + ", " + name + ": sum of forces", sum.norm() / size, 1e-13);
      expect_below(std::string(law) + ", " + name + ": sum of torques", torque.norm() / size, 1e-10);
    }
  }
}

TEST(Inversion, NothingForHealthyStates) {
  const auto device = open_double();
  Matrix3 sheared;
  sheared << 1.2, 0.3, 0, -0.1, 0.8, 0.2, 0, 0.1, 0.5;
  for (const char* law : {"ordinary", "stvk"}) {
    Stage stage(lattice(6, 5, 4, spacing), spacing, pushed(law), 1. / 60),
        bare(lattice(6, 5, 4, spacing), spacing, pushed(law, 0.25, "none"), 1. / 60);
    for (Stage* one : {&stage, &bare}) {
      one->scene.solver.method = "newton";
      one->move([&](const Vector3& x) -> Vector3 { return sheared * x; });
    }
    Simulation simulation(*device, stage.scene, stage.model), without(*device, bare.scene, bare.model);
    for (int k = 0; k < 3; ++k) simulation.step(), without.step();
    EXPECT_EQ(largest_difference(simulation.positions(), without.positions()), 0) << law;
  }
}

// F^ held: a bound of the true derivative, symmetric, and never negative.
TEST(Inversion, DerivativeIsAPositiveBound) {
  const auto device = open_double();
  Stage stage(lattice(5, 4, 4, spacing), spacing, pushed("ordinary"), 1. / 60),
      bare(lattice(5, 4, 4, spacing), spacing, pushed("ordinary", 0.25, "none"), 1. / 60);
  std::vector<Vector3> u;
  std::mt19937 random(9);
  for (const Vector3& x : stage.model.position)
    u.push_back(Vector3(-1.8 * x.x(), 0, 0) + 0.1 * spacing * random_vector(random));
  for (Stage* one : {&stage, &bare}) {
    one->scene.solver.method = "newton";
    one->model.mass.assign(one->model.count(), 1e-30);
  }
  SolveRig rig(*device, stage.scene, stage.model), without(*device, bare.scene, bare.model);
  const auto field = [&] {
    std::vector<Vector3> v(u.size());
    for (Vector3& one : v) one = random_vector(random);
    return v;
  };
  const double s = 1e-5 * spacing;
  for (int trial = 0; trial < 6; ++trial) {
    const std::vector<Vector3> p = field(), q = field();
    const auto push = [&](const std::vector<Vector3>& at) {
      return plus(rig.forces(at), -1, without.forces(at));
    };
    const double actual = -inner(p, plus(push(plus(u, s, p)), -1, push(plus(u, -s, p)))) / (2 * s);
    rig.forces(u), without.forces(u);
    const std::vector<Vector3> hp = plus(rig.product(p), -1, without.product(p)),
                               hq = plus(rig.product(q), -1, without.product(q));
    EXPECT_GT(inner(p, hp), 0);
    EXPECT_GE(inner(p, hp), actual * (1 - 1e-6));
    EXPECT_LT(std::abs(inner(p, hq) - inner(q, hp)), 1e-11 * std::sqrt(inner(p, p) * inner(hq, hq)));
  }
}

struct Start {
  const char* name;
  std::function<Vector3(const Vector3&)> map; ///< from the centre
};

std::vector<Start> starts() {
  return {{"plane", [](const Vector3& x) { return Vector3(0, x.y(), x.z()); }},
          {"line", [](const Vector3& x) { return Vector3(x.x(), 0, 0); }},
          {"point", [](const Vector3&) { return Vector3(0, 0, 0); }},
          {"mirror", [](const Vector3& x) { return Vector3(-x.x(), x.y(), x.z()); }},
          {"one particle pushed through", [](const Vector3& x) -> Vector3 {
             const bool top = x.z() > 1.9 * spacing && std::abs(x.x()) + std::abs(x.y()) < 0.1 * spacing;
             return top ? Vector3(x - Vector3(0, 0, 2.3 * spacing)) : x;
           }}};
}

struct Recovered {
  double strain = 0, upright = 0; ///< rms of bonds; share of particles with det F > 0
};

Recovered recover(Device& device, const Material& material, const Start& start) {
  Stage stage(lattice(5, 5, 5, spacing), spacing, material, 1. / 30);
  stage.scene.solver.method = "newton";
  stage.scene.solver.tolerance = 1e-3;
  Vector3 centre = Vector3::Zero();
  for (const Vector3& x : stage.model.position) centre += x / static_cast<double>(stage.model.count());
  stage.move([&](const Vector3& x) { return start.map(x - centre); });
  Simulation simulation(device, stage.scene, stage.model);
  for (int k = 0; k < 60; ++k) simulation.step();
  const Points y = simulation.positions();
  Recovered result;
  for (std::uint32_t i = 0; i < y.size(); ++i) {
    EXPECT_TRUE(y[i].allFinite());
    if (determinant(deformation_gradient(stage.model, y, i)) > 0) result.upright += 1;
  }
  result.upright /= static_cast<double>(y.size());
  result.strain = rms_bond_strain(stage.model, y);
  return result;
}

// Every neighbourhood is upright again. The law over B_1 comes back whole, except that after a mirror image
// corners may stay flat, held at the edge of what is pushed (0.1) by bonds that pull them in: a corner has
// seven bonds, which are in its neighbours' energies too. So may corners of the other laws from any start:
// which side a collapsed corner leaves to is a matter of the path.
// (Folded corners are at rest upright, with a least singular value of up to .3. Pushing below .4, with two to
// four times the stiffness, brings all of these back whole, but meets bodies that are only crushed: Fig. 14's
// then keeps .62 of its height, not .52.)
TEST(Inversion, BodiesComeBack) {
  const auto device = open_alone({"openmp", "openmp", Precision::single_precision});
  for (const char* law : {"ordinary", "stvk", "basis"})
    for (const double poisson : law == std::string("basis") ? std::vector{0.25} : std::vector{0.25, 0.45})
      for (const Start& start : starts()) {
        const Recovered now = recover(*device, pushed(law, poisson), start);
        const std::string name =
            std::string(law) + " " + std::to_string(poisson).substr(0, 4) + ", " + start.name;
        const bool whole = law == std::string("ordinary") && start.name != std::string("mirror");
        expect_below(name + ": rms strain left", now.strain, whole ? 1e-5 : 0.1);
        expect_above(name + ": share with det F > 0", now.upright, 1);
      }
}

// Without it bonds are at rest in a mirror image. The exact neo-Hookean law leaves the plane and the mirror
// image by itself; a line or a point it does not leave: F = 0 is a least of its energy.
TEST(Inversion, WithoutItBondsStayInverted) {
  const auto device = open_alone({"openmp", "openmp", Precision::single_precision});
  const std::vector<Start> all = starts();
  const Recovered mirror = recover(*device, pushed("ordinary", 0.25, "none"), all[3]),
                  plane = recover(*device, pushed("neo-hookean", 0.25, "none"), all[0]),
                  other = recover(*device, pushed("neo-hookean", 0.25, "none"), all[3]),
                  point = recover(*device, pushed("neo-hookean", 0.25, "none"), all[2]);
  expect_below("ordinary, mirrored, left alone: share with det F > 0", mirror.upright, 0.01);
  expect_below("ordinary, mirrored, left alone: rms strain", mirror.strain, 1e-2);
  expect_below("neo-hookean, plane: rms strain left", plane.strain, 1e-2);
  expect_below("neo-hookean, mirrored: rms strain left", other.strain, 1e-2);
  expect_above("neo-hookean, a point, left alone: rms strain", point.strain, 0.9);
}

} // namespace
} // namespace pliant::test
