// Laws over basis functions in motion: the potential never rises, momentum stays, a turned scene does the
// same, devices and threads agree, every solver finds the same state.
#include "tests/laws/materials.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.125;

/// A bar that is let go from a strong deformation.
Stage sprung(const Material& material, const Matrix3& turn = Matrix3::Identity()) {
  Points points = lattice(6, 3, 3, spacing);
  Stage stage(points, spacing, material, 1. / 60);
  Matrix3 map;
  map << 1.4, 0.2, 0, 0, 0.8, 0.1, 0, 0, 0.9;
  stage.move([&](const Vector3& x) -> Vector3 { return turn * (map * x); });
  stage.scene.solver.method = "newton";
  stage.scene.solver.preconditioner = "diagonal";
  return stage;
}

TEST(StretchMotion, ThePotentialNeverRises) {
  const auto device = open_double();
  for (const char* method : {"newton", "lbfgs", "direct"})
    for (const auto& [name, material] : some_materials(1e6, 0.3)) {
      Stage stage = sprung(material);
      stage.scene.solver.method = method;
      stage.scene.solver.tolerance = 1e-8;
      double before = 0;
      Points start, last;
      for (const unsigned budget : {0u, 1u, 2u, 4u, 8u, 16u, 60u}) {
        stage.scene.solver.iterations = budget;
        Simulation simulation(*device, stage.scene, stage.model);
        ASSERT_TRUE(simulation.plan().method.potential);
        simulation.begin_solving();
        while (!simulation.iterate()) {
        }
        const Points y = simulation.iterate_positions();
        const double phi = simulation.potential(y);
        ASSERT_TRUE(std::isfinite(phi)) << name;
        if (budget > 0) {
          EXPECT_LE(phi, before * (1 + 1e-13)) << name << ", " << method << ", " << budget << " iterations";
        }
        before = phi;
      }
    }
}

TEST(StretchMotion, SolversFindTheSameState) {
  const auto device = open_double();
  for (const auto& [name, material] : some_materials(1e5, 0.3)) {
    Points wanted;
    for (const auto& [method, preconditioner] : {std::pair{"newton", "diagonal"},
                                                 {"newton", "multilevel"},
                                                 {"lbfgs", "diagonal"},
                                                 {"direct", "auto"},
                                                 {"chebyshev", "auto"},
                                                 {"jacobi", "auto"}}) {
      Stage stage = sprung(material);
      stage.scene.solver.method = method;
      stage.scene.solver.preconditioner = preconditioner;
      stage.scene.solver.tolerance = 1e-10;
      stage.scene.solver.iterations = 20000;
      Simulation simulation(*device, stage.scene, stage.model);
      simulation.step();
      const StepStatistics row = simulation.take_statistics().front();
      EXPECT_NE(row.reason, StopReason::cap) << name << ", " << method;
      if (wanted.empty()) wanted = simulation.positions();
      expect_below(name + ", " + method + " " + preconditioner + ": difference, spacings",
                   largest_difference(simulation.positions(), wanted) / spacing, 1e-7);
    }
  }
}

TEST(StretchMotion, MomentumStays) {
  const auto device = open_double();
  for (const auto& [name, material] : some_materials(1e5, 0.3)) {
    Stage stage = sprung(material);
    stage.scene.solver.tolerance = 1e-11;        // what the solve leaves undone is momentum gained
    stage.scene.solver.restore_momentum = false; // what is not there by itself shows
    stage.model.velocity = random_field(stage.model.count(), 5);
    Simulation simulation(*device, stage.scene, stage.model);
    const auto momentum = [&](const std::vector<Vector3>& v) {
      Vector3 sum = Vector3::Zero();
      for (std::size_t i = 0; i < v.size(); ++i) sum += stage.model.mass[i] * v[i];
      return sum;
    };
    const Vector3 first = momentum(simulation.velocities());
    for (int k = 0; k < 10; ++k) simulation.step();
    double size = 0;
    for (std::size_t i = 0; i < stage.model.count(); ++i)
      size += stage.model.mass[i] * stage.model.velocity[i].norm();
    expect_below(name + ": momentum after ten steps",
                 (momentum(simulation.velocities()) - first).norm() / size, 1e-9);
  }
}

// A scene turned, its directions with it, does the same turned.
TEST(StretchMotion, DirectionsTurnWithTheScene) {
  const auto device = open_double();
  const Matrix3 turn = Eigen::AngleAxisd(1.1, Vector3(1, 2, -2) / 3).toRotationMatrix();
  const Matrix3 rows = Eigen::AngleAxisd(0.4, Vector3(2, -1, 2) / 3).toRotationMatrix();
  for (const bool around : {false, true}) {
    Points ran[2];
    for (const bool turned : {false, true}) {
      const Matrix3 q = turned ? turn : Matrix3::Identity();
      Scene scene;
      scene.simulation.spacing = spacing;
      scene.simulation.gravity = Vector3::Zero();
      scene.solver.method = "newton";
      scene.solver.tolerance = 1e-10;
      Material material = basis_of(1e5, 0.3, {{"A2", 1}}, {{"A2", 1}});
      material.anisotropy = directions_of({4, 0.25, 1}, Matrix3(rows * q.transpose()));
      material.anisotropy.around = around;
      material.anisotropy.around_axis = q * Vector3(0.6, 0, 0.8);
      material.anisotropy.around_through = q * Vector3(0.1, -0.7, 0.2);
      scene.materials = {material};
      Body body;
      body.name = "bar";
      body.material = "basis";
      body.shape.size = spacing * Vector3(6, 3, 3);
      const Eigen::AngleAxisd about(q);
      body.shape.rotate_axis = turned ? about.axis() : Vector3::UnitY();
      body.shape.rotate_degrees = turned ? about.angle() * 180 / 3.14159265358979323846 : 0;
      body.spin = q * Vector3(3, 1, 5);
      body.deform = q * Vector3(1.2, 0.9, 1).asDiagonal() * q.transpose();
      scene.bodies = {body};
      const Model model = assemble(scene);
      Simulation simulation(*device, scene, model);
      for (int k = 0; k < 8; ++k) simulation.step();
      for (const Vector3& y : simulation.positions()) ran[turned].push_back(q.transpose() * y);
    }
    expect_below(std::string(around ? "around an axis" : "three directions") + ": turned scene, spacings",
                 largest_difference(ran[0], ran[1]) / spacing, 1e-8);
  }
}

// Float and GL against double. A float holds places of some 0.5 m to 3e-8 m, 2e-7 spacings, in each of two
// steps; the stiffness number is near 1, so the solve amplifies that by a few times at most.
TEST(StretchMotion, DevicesAgree) {
  const auto exact = open_double();
  for (const auto& [name, material] : some_materials(1e5, 0.3)) {
    Stage stage = sprung(material);
    stage.scene.solver.tolerance = 1e-5;
    Points wanted;
    const auto run = [&](Device& device) {
      Simulation simulation(device, stage.scene, stage.model);
      simulation.step();
      simulation.step();
      return simulation.positions();
    };
    wanted = run(*exact);
    for (const DeviceChoice& choice : device_choices()) {
      const auto device = open_alone(choice);
      expect_below(name + " on " + choice.name + ": difference, spacings",
                   largest_difference(run(*device), wanted) / spacing, 4e-6);
    }
  }
}

TEST(StretchMotion, SameBitsForAnyNumberOfThreads) {
  Material material = basis_of(1e5, 0.3, {{"A2", 1}}, {{"A4", 0.5}, {"B1", 0.5}});
  material.anisotropy = directions_of({2, 0.5, 1});
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    std::string first;
    for (const unsigned threads : {1u, 2u}) {
      const auto device = open_alone({"", "openmp", precision}, threads);
      Stage stage = sprung(material);
      Simulation simulation(*device, stage.scene, stage.model);
      for (int k = 0; k < 3; ++k) simulation.step();
      if (threads == 1) first = simulation.hash();
      EXPECT_EQ(simulation.hash(), first);
    }
  }
}

// R13: drawn to five times its length or crushed to a twentieth, a body comes back.
TEST(StretchMotion, RecoversFromExtremeStretch) {
  const auto device = open_double();
  for (const char* basis : {"A4", "B4"})
    for (const double factor : {5.0, 0.05}) {
      const Material material = basis_of(1e5, 0.3, {{basis, 1}}, {{basis, 1}});
      Stage stage(lattice(6, 3, 3, spacing), spacing, material, 1. / 30);
      const Points rest = stage.model.position;
      stage.move([&](const Vector3& x) -> Vector3 { return {factor * x.x(), x.y(), x.z()}; });
      stage.scene.solver.method = "newton";
      stage.scene.solver.tolerance = 1e-4;
      Simulation simulation(*device, stage.scene, stage.model);
      for (int k = 0; k < 60; ++k) simulation.step();
      expect_below(std::string(basis) + " from " + std::to_string(factor).substr(0, 4) +
                       " of its length: strain left",
                   rms_bond_strain(stage.model, simulation.positions()), 1e-2);
    }
}

} // namespace
} // namespace pliant::test
