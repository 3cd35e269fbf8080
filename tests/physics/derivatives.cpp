// The derivatives that Newton's method works with, against central differences of the forces, and the
// potential that its line search descends, against the forces.
#include "tests/support/solve_rig.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.1;

struct Deformed {
  const char* name;
  Matrix3 affine;
  double noise; ///< spacings
};

std::vector<Deformed> deformations() {
  Matrix3 sheared = Matrix3::Identity(), squeezed = Matrix3::Identity();
  sheared << 1.2, 0.3, 0, -0.1, 0.8, 0.2, 0, 0.1, 1.1;
  squeezed.diagonal() << 0.5, 1.3, 1.3;
  const Matrix3 turned = Eigen::AngleAxisd(2.5, Vector3(1, 2, -2) / 3).toRotationMatrix();
  return {
      {"at rest", Matrix3::Identity(), 0},
      {"near rest", Matrix3::Identity(), 0.05},
      {"turned and sheared", turned * sheared, 0.1},
      {"squeezed", squeezed, 0.15},
      // A bound of eigenvalues by rows of the matrix would hold this one away from singular, which it is not.
      {"inverted askew", 1.15 * Matrix3::Identity() - 1.85 / 3 * Matrix3::Ones(), 0.05}};
}

std::vector<Vector3> displacements(const Model& model, const Deformed& state, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Vector3> u;
  for (const Vector3& x : model.position)
    u.push_back(state.affine * x - x + state.noise * spacing * random_vector(random));
  return u;
}

std::vector<Vector3> random_field(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Vector3> v(count);
  for (Vector3& one : v) one = random_vector(random);
  return v;
}

double size_of(const std::vector<Vector3>& v) {
  return std::sqrt(inner(v, v));
}

/// Without inertia, so that the product is the derivative of the force alone.
Stage floating(const char* law, double poisson, const char* method = "newton") {
  Stage stage(lattice(5, 4, 4, spacing), spacing, material_of(law, 1e5, poisson), 1. / 60);
  stage.scene.solver.method = method;
  stage.model.mass.assign(stage.model.count(), 1e-30);
  return stage;
}

/// df/du p by differences of fourth order.
std::vector<Vector3> difference(SolveRig& rig, const std::vector<Vector3>& u, const std::vector<Vector3>& p) {
  const double s = 2e-4 * spacing;
  const auto f = [&](double t) { return rig.forces(plus(u, t * s, p)); };
  std::vector<Vector3> sum = plus(f(1), -1, f(-1));
  for (Vector3& v : sum) v *= 8;
  sum = plus(plus(sum, -1, f(2)), 1, f(-2));
  for (Vector3& v : sum) v /= 12 * s;
  return sum;
}

TEST(Derivatives, OfElasticForces) {
  const auto device = open_double();
  for (const char* law : {"corotated", "ordinary", "neo-hookean"})
    for (const double poisson : {0.0, 0.25, 0.45}) {
      const Stage stage = floating(law, poisson);
      SolveRig rig(*device, stage.scene, stage.model);
      const std::size_t n = stage.model.count();
      for (const Deformed& state : deformations()) {
        const std::vector<Vector3> u = displacements(stage.model, state, 21);
        double worst = 0, asymmetry = 0;
        for (unsigned trial = 0; trial < 4; ++trial) {
          std::vector<Vector3> p = random_field(n, 30 + trial);
          if (trial > 1) { // one particle alone: nothing averages out
            const Vector3 one = p[trial];
            p.assign(n, Vector3::Zero());
            p[17 * trial] = one;
          }
          const std::vector<Vector3> wanted = difference(rig, u, p);
          rig.forces(u);
          const std::vector<Vector3> hp = rig.product(p);
          worst = std::max(worst, size_of(plus(hp, 1, wanted)) / size_of(wanted));
          const std::vector<Vector3> q = random_field(n, 50 + trial), hq = rig.product(q);
          asymmetry = std::max(asymmetry, std::abs(inner(p, hq) - inner(q, hp)) / (size_of(p) * size_of(hq)));
        }
        const std::string name =
            std::string(law) + ", " + std::to_string(poisson).substr(0, 4) + ", " + state.name;
        expect_below(name, worst, 1e-7);
        expect_below(name + ": |p.Hq - q.Hp|", asymmetry, 1e-12);
      }
    }
}

// A rigid motion costs nothing at rest: the derivative knows no spurious stiffness.
TEST(Derivatives, RigidMotionsAtRest) {
  const auto device = open_double();
  for (const char* law : {"corotated", "ordinary", "neo-hookean"}) {
    const Stage stage = floating(law, 0.3);
    SolveRig rig(*device, stage.scene, stage.model);
    rig.forces(std::vector<Vector3>(stage.model.count(), Vector3::Zero()));
    const double stiffness = size_of(rig.product(random_field(stage.model.count(), 3)));
    std::vector<Vector3> turn;
    for (const Vector3& x : stage.model.position)
      turn.push_back(Vector3(1, -2, 0.5).cross(x) + Vector3(1, 1, 0));
    expect_below(std::string(law) + ": rigid motion", size_of(rig.product(turn)) / stiffness, 1e-12);
  }
}

/// The least eigenvalue of -df/du over the largest, by power iterations on the one shifted by the other.
double least_eigenvalue(SolveRig& rig, std::size_t n) {
  std::vector<Vector3> v = random_field(n, 77), none(n, Vector3::Zero());
  double largest = 0, least = 0;
  for (int k = 0; k < 60; ++k) {
    v = plus(none, 1 / size_of(v), v);
    v = rig.product(v);
    largest = 1.1 * size_of(v);
  }
  v = random_field(n, 78);
  for (int k = 0; k < 400; ++k) {
    v = plus(none, 1 / size_of(v), v);
    const std::vector<Vector3> hv = rig.product(v);
    least = inner(v, hv);
    v = plus(plus(none, largest, v), -1, hv);
  }
  return least / largest;
}

// A crushed body may buckle: its derivative is indefinite. The convex one is not, whatever the state.
TEST(Derivatives, ConvexOnesAreNotNegative) {
  const auto device = open_double();
  for (const auto& [law, poisson] : {std::pair{"corotated", 0.0},
                                     {"corotated", 0.25},
                                     {"corotated", 0.45},
                                     {"neo-hookean", 0.0},
                                     {"neo-hookean", 0.45}}) {
    const Stage stage = floating(law, poisson);
    SolveRig rig(*device, stage.scene, stage.model);
    const std::size_t n = stage.model.count();
    const std::vector<Vector3> u =
        displacements(stage.model, {"crushed", 0.5 * Matrix3::Identity(), 0.3}, 22);
    rig.forces(u);
    const double exact = least_eigenvalue(rig, n);
    rig.convex = true;
    rig.forces(u);
    const double convex = least_eigenvalue(rig, n);
    report(std::string(law) + " crushed, ratio " + std::to_string(poisson).substr(0, 4) +
               ": least eigenvalue over largest",
           exact);
    EXPECT_LT(exact, -1e-2);
    report("  kept positive", convex);
    EXPECT_GT(convex, -1e-3);
  }
}

// Where two of the signed singular values cancel the rotation has no derivative: what stands for it is finite
// and of the size of the stiffness.
TEST(Derivatives, OfFlatAndInvertedNeighbourhoodsAreBounded) {
  const auto device = open_double();
  for (const double poisson : {0.0, 0.45}) {
    const Stage stage = floating("corotated", poisson);
    SolveRig rig(*device, stage.scene, stage.model);
    const std::size_t n = stage.model.count();
    const std::vector<Vector3> p = random_field(n, 5);
    rig.forces(std::vector<Vector3>(n, Vector3::Zero()));
    const double rest = size_of(rig.product(p));
    for (const Vector3& stretch : {Vector3(1, 0, 1), Vector3(1, 0, 0), Vector3(0, 0, 0), Vector3(-1, 1, 1)}) {
      const std::vector<Vector3> u =
          displacements(stage.model, {"", Matrix3(stretch.asDiagonal()), stretch.x() < 0 ? 0.05 : 0}, 4);
      rig.forces(u);
      const std::vector<Vector3> hp = rig.product(p), q = random_field(n, 6), hq = rig.product(q);
      // A turn of the rotation is at most 1 / 0.02 of what turns it, times the scale of A.
      expect_below("singular neighbourhood: |Hp|, of that at rest", size_of(hp) / rest,
                   50 * (1 + stage.model.constants[0].coupling));
      expect_below("singular neighbourhood: |p.Hq - q.Hp|",
                   std::abs(inner(p, hq) - inner(q, hp)) / (size_of(p) * size_of(hq)), 1e-12);
    }
  }
}

// --- The potential ---------------------------------------------------------------------------------------

/// Error of Phi's slope along random directions against -(m / h^2)(y* - y) . d - f . d, of |gradient| |d|.
double potential_error(const Scene& scene, const Model& model, const std::vector<Vector3>& u,
                       double* acting) {
  const auto device = open_double();
  Simulation simulation(*device, scene, model);
  SolveRig rig(*device, scene, model);
  const std::vector<Vector3> f = rig.forces(u);
  const auto rest = simulation.positions();
  const double h = scene.simulation.time_step;
  std::vector<Vector3> gradient(f.size());
  for (std::size_t i = 0; i < f.size(); ++i) {
    const Vector3 target = h * model.velocity[i] + h * h * scene.simulation.gravity;
    gradient[i] = model.mass[i] / (h * h) * (u[i] - target) - f[i];
  }
  simulation.begin_solving();
  const auto y = plus(rest, 1, u);
  double worst = 0;
  for (unsigned trial = 0; trial < 8; ++trial) {
    std::vector<Vector3> d = random_field(f.size(), 70 + trial);
    if (trial > 3) {
      const Vector3 one = d[trial];
      const std::size_t at = (31 * trial) % d.size();
      d.assign(d.size(), Vector3::Zero());
      d[at] = one;
    }
    const double s = 3e-5 * spacing;
    const auto phi = [&](double t) { return simulation.potential(plus(y, t * s, d)); };
    const double slope = (8 * (phi(1) - phi(-1)) - (phi(2) - phi(-2))) / (12 * s);
    worst = std::max(worst, std::abs(slope - inner(gradient, d)) / (size_of(gradient) * size_of(d)));
  }
  if (acting) {
    *acting = 0;
    const Stage alone = [&] {
      Stage stage(lattice(2, 2, 2, spacing), spacing, material_of("corotated", 1e5, 0.3), h);
      stage.scene = scene, stage.model = model;
      stage.scene.boundaries.clear();
      stage.scene.contact.bodies = false;
      return stage;
    }();
    SolveRig without(*device, alone.scene, alone.model);
    *acting = size_of(plus(f, -1, without.forces(u))) / size_of(f);
  }
  return worst;
}

TEST(Potential, GradientOfInertiaAndElasticity) {
  for (const char* law : {"corotated", "ordinary", "neo-hookean"}) {
    Stage stage(lattice(5, 4, 4, spacing), spacing, material_of(law, 1e5, 0.3), 1. / 60);
    stage.scene.solver.method = "newton";
    stage.scene.simulation.gravity = {0, -9.81, 1};
    stage.model.velocity = random_field(stage.model.count(), 8);
    const std::vector<Vector3> u = displacements(stage.model, {"", deformations()[2].affine, 0.1}, 12);
    expect_below(std::string("Phi, ") + law, potential_error(stage.scene, stage.model, u, nullptr), 1e-7);
  }
}

TEST(Potential, GradientWithObstacles) {
  Stage stage(lattice(5, 4, 4, spacing), spacing, material_of("corotated", 1e5, 0.3), 1. / 60);
  stage.scene.solver.method = "newton";
  Boundary floor, ball;
  floor.shape.kind = Shape::Kind::plane;
  floor.shape.normal = Vector3(1, 2, -2) / 3;
  floor.shape.offset = floor.shape.normal.dot(stage.model.position[0]);
  ball.shape.kind = Shape::Kind::sphere;
  ball.shape.at = stage.model.position.back() + Vector3(0.2, 0.2, 0.2);
  ball.shape.radius = 0.45;
  stage.scene.boundaries = {floor, ball};
  const std::vector<Vector3> u = displacements(stage.model, deformations()[1], 14);
  double acting = 0;
  expect_below("Phi with two obstacles", potential_error(stage.scene, stage.model, u, &acting), 1e-7);
  expect_above("obstacles' forces, of all", acting, 0.1);
}

TEST(Potential, GradientWithPairs) {
  Scene scene;
  scene.simulation.spacing = spacing;
  scene.simulation.gravity = Vector3::Zero();
  scene.simulation.time_step = 1. / 60;
  scene.output.fps = 60;
  scene.contact.friction = 0;
  scene.solver.method = "newton";
  scene.materials = {material_of("corotated", 1e5, 0.3)};
  for (int k = 0; k < 2; ++k) {
    Body body;
    body.name = k ? "upper" : "lower";
    body.material = scene.materials[0].name;
    body.shape.kind = Shape::Kind::box;
    body.shape.size = Vector3(0.4, 0.3, 0.3);
    body.shape.at = Vector3(0.03 * k, 0.3 * k, 0.02 * k);
    scene.bodies.push_back(body);
  }
  const Model model = assemble(scene);
  std::vector<Vector3> u = random_field(model.count(), 15);
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] = 0.1 * spacing * u[i] + Vector3(0, model.body[i] ? -0.3 : 0.1, 0) * spacing;
  double acting = 0;
  expect_below("Phi with two bodies that touch", potential_error(scene, model, u, &acting), 1e-7);
  expect_above("contact forces, of all", acting, 0.05);
}

} // namespace
} // namespace pliant::test
