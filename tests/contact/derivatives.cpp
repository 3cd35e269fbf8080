// The derivative of contact forces that Newton's method uses: the penalty along the contact, friction's
// secant across it; exact but for what would make it indefinite.
#include "tests/contact/world.h"

#include <Eigen/Eigenvalues>

namespace pliant::test {
namespace {

constexpr double k = 1000;

struct Rig {
  std::unique_ptr<Device> device;
  World world;
  std::unique_ptr<Bench> bench;
  std::unique_ptr<Contacts> contacts;

  explicit Rig(const World& given) : world(given) {
    DeviceRequest request;
    request.backend = "openmp";
    request.precision = Precision::double_precision;
    request.threads = 1;
    device = open_device(request);
    bench = std::make_unique<Bench>(*device, world);
    contacts = std::make_unique<Contacts>(*device, world.scene, world.model, Vector3::Zero(),
                                          ContactUse{.potential = false, .tangent = true});
    contacts->begin_step(0, world.step, bench->state);
    contacts->find(bench->state);
  }
  std::vector<Vector3> forces(const std::vector<Vector3>& u) {
    bench->move(u);
    zero();
    contacts->add_forces(bench->state);
    return read();
  }
  /// -df/du of the last forces(), dense.
  Eigen::MatrixXd matrix() {
    const std::size_t n = world.count();
    Eigen::MatrixXd found = Eigen::MatrixXd::Zero(Eigen::Index(3 * n), Eigen::Index(3 * n));
    std::vector<double> solver(SOLVER_ENTRIES, 0.0);
    solver[SOLVER_LINEAR] = 1;
    device->upload(bench->state.solver, solver);
    Buffer direction = device->allocate("direction", Type::real4, n);
    for (std::size_t c = 0; c < 3 * n; ++c) {
      std::vector<Real4<double>> p(n, Real4<double>{0, 0, 0, 0});
      (c % 3 == 0 ? p[c / 3].x : c % 3 == 1 ? p[c / 3].y : p[c / 3].z) = 1;
      device->upload(direction, p);
      zero();
      contacts->add_product(bench->state, bench->state.displacement, direction);
      const std::vector<Vector3> f = read();
      for (std::size_t r = 0; r < 3 * n; ++r)
        found(Eigen::Index(r), Eigen::Index(c)) = -f[r / 3][Eigen::Index(r % 3)];
    }
    if (!contacts->block()) return found;
    const std::vector<Real4<double>> block = device->download_real4(contacts->block());
    for (std::size_t i = 0; i < n; ++i) {
      const Real4<double>&a = block[2 * i], &b = block[2 * i + 1];
      const Matrix3 own = (Matrix3() << a.x, a.y, a.z, a.y, a.w, b.x, a.z, b.x, b.y).finished();
      found.block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * i)) += own;
    }
    return found;
  }
  Eigen::MatrixXd difference(const std::vector<Vector3>& u) {
    const std::size_t n = world.count();
    Eigen::MatrixXd found(Eigen::Index(3 * n), Eigen::Index(3 * n));
    const double s = 1e-6;
    for (std::size_t c = 0; c < 3 * n; ++c) {
      std::vector<Vector3> up = u, down = u;
      up[c / 3][Eigen::Index(c % 3)] += s, down[c / 3][Eigen::Index(c % 3)] -= s;
      const std::vector<Vector3> more = forces(up), less = forces(down);
      for (std::size_t r = 0; r < 3 * n; ++r)
        found(Eigen::Index(r), Eigen::Index(c)) = -(more[r / 3] - less[r / 3])[Eigen::Index(r % 3)] / (2 * s);
    }
    return found;
  }

private:
  void zero() {
    device->upload(bench->state.force, std::vector<Real4<double>>(world.count(), Real4<double>{0, 0, 0, 0}));
  }
  std::vector<Vector3> read() {
    std::vector<Vector3> found;
    for (const Real4<double>& f : device->download_real4(bench->state.force)) found.push_back(vector_of(f));
    return found;
  }
};

/// Two particles of different bodies that overlap by a fifth of the contact distance.
World pair(double friction, const Vector3& u) {
  World world;
  world.scene.contact.bodies = true;
  world.scene.contact.friction = friction;
  world.add_body(Vector3::Zero());
  world.add(Vector3::Zero(), Vector3::Zero(), k);
  world.add_body(Vector3::Zero());
  world.add(0.072 * Vector3(2, -1, 2) / 3, u, 3 * k);
  return world;
}

void expect_semidefinite(const Eigen::MatrixXd& m) {
  EXPECT_LT((m - m.transpose()).norm(), 1e-12 * m.norm());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m).eigenvalues()[0], -1e-12 * m.norm());
  EXPECT_GT(m.norm(), 0.1 * k);
}

// Without friction: exact but for the turning of the normal, -k (d - r) / r across it, which is left out.
TEST(ContactDerivatives, PairWithoutFriction) {
  for (const Vector3& u : {Vector3(0, 0, 0), Vector3(0.004, 0.002, -0.003)}) {
    const World world = pair(0, u);
    Rig rig(world);
    rig.forces(world.displacement);
    const Eigen::MatrixXd found = rig.matrix();
    expect_semidefinite(found);
    const Eigen::MatrixXd exact = rig.difference(world.displacement);
    const Vector3 y = world.model.position[1] + u;
    const double r = y.norm(), d = 0.09;
    const Matrix3 across = Matrix3::Identity() - y * y.transpose() / (r * r);
    Eigen::MatrixXd left_out(6, 6);
    left_out << across, -across, -across, across;
    EXPECT_LT((found - k / 2 * (d - r) / r * left_out - exact).norm(), 1e-6 * found.norm());
  }
}

// With friction across: the spring where it holds, its secant where it slips; what it gives for the slip
// itself is the force.
TEST(ContactDerivatives, PairWithFriction) {
  for (const double slip : {1e-4, 0.02}) {
    const Vector3 n = Vector3(2, -1, 2) / 3, t = Vector3(1, 2, 0) / std::sqrt(5.0);
    const World world = pair(0.5, slip * t);
    Rig rig(world);
    const std::vector<Vector3> f = rig.forces(world.displacement);
    const Eigen::MatrixXd found = rig.matrix();
    expect_semidefinite(found);
    const Vector3 y = world.model.position[1] + slip * t, now = y.normalized();
    const Vector3 slide = slip * t - now.dot(slip * t) * now;
    const Matrix3 own = found.block<3, 3>(3, 3);
    EXPECT_LT((own * now - k / 2 * now).norm(), 1e-10 * k) << "along the contact";
    const Vector3 friction = f[1] - now.dot(f[1]) * now;
    EXPECT_LT((own * slide + friction).norm(), 1e-10 * k * slip) << "across it";
    EXPECT_NEAR(friction.norm(), std::min(k / 2 * slide.norm(), 0.5 * k / 2 * (0.09 - y.norm())), 1e-10);
    EXPECT_GT(now.dot(n), 0.9);
  }
}

// Of a plane without friction, and of one that holds, the block is the exact derivative.
TEST(ContactDerivatives, Planes) {
  for (const bool slip : {true, false})
    for (const Vector3& u : {Vector3(0, 0, 0), Vector3(0.01, -0.02, 0.005)}) {
      World world;
      Shape shape;
      shape.kind = Shape::Kind::plane;
      shape.normal = Vector3(1, 2, -2) / 3;
      world.add_boundary(shape);
      world.scene.boundaries[0].slip = slip;
      world.add(0.01 * shape.normal, u, k);
      Rig rig(world);
      rig.forces(world.displacement);
      const Eigen::MatrixXd found = rig.matrix();
      expect_semidefinite(found);
      EXPECT_LT((found - rig.difference(world.displacement)).norm(), 1e-6 * k) << (slip ? "slips" : "holds");
    }
}

TEST(ContactDerivatives, RoundObstaclesAlongTheNormal) {
  World world;
  Shape shape;
  shape.kind = Shape::Kind::sphere;
  shape.radius = 0.5;
  world.add_boundary(shape, false, 0.3);
  const Vector3 n = Vector3(2, 1, -2) / 3;
  world.add(0.53 * n, Vector3(0.001, 0.002, 0.001), k);
  Rig rig(world);
  rig.forces(world.displacement);
  const Eigen::MatrixXd found = rig.matrix();
  expect_semidefinite(found);
  const Vector3 now = (0.53 * n + world.displacement[0]).normalized();
  EXPECT_LT((found * now - k * now).norm(), 1e-9 * k);
}

} // namespace
} // namespace pliant::test
