// Energies, forces and their derivative of bodies with broken bonds (physics of a broken bond: stretch 1 in
// the dilatation, nothing else), against a plain formula and against each other.
#include "tests/failure/broken.h"

#include <Eigen/SVD>

namespace pliant::test {
namespace {

constexpr double spacing = 0.125; // positions are exact in float

double size_of(const std::vector<Vector3>& v) {
  return std::sqrt(inner(v, v));
}

/// A rig whose bonds a noise of 0.3 spacings has broken; about a fifth of them.
struct Broken {
  Stage stage;
  SolveRig rig;
  std::vector<bool> broken;
  Broken(Device& device, const Material& material)
      : stage(breakable_stage(material, spacing)), rig(device, stage.scene, stage.model) {
    const std::vector<Vector3> u = noisy(stage.model, 0.3, 7);
    broken = broken_by(stage.model, u);
    rig.forces(u);
    rig.break_bonds(u);
    const auto gone = std::count(broken.begin(), broken.end(), true);
    EXPECT_GT(gone, static_cast<long>(broken.size() / 10));
    EXPECT_LT(gone, static_cast<long>(broken.size() / 2));
  }
};

// sum V_i W_i, with theta - 1 = sum over whole bonds of omega (s - 1): law M2; and of law M4 with the
// rotation of the whole bonds' S and theta - 1 = sum omega ((R xi) . Y / x^2 - 1).
double energy_by_hand(const Model& model, const std::string& law, const std::vector<Vector3>& u,
                      const std::vector<bool>& broken) {
  double sum = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    const LawConstants& constants = model.constants[model.material[i]];
    const auto over_bonds = [&](auto&& visit) {
      for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
        if (broken[b]) continue;
        const std::uint32_t j = model.bonds.neighbour[b];
        const Vector3 xi = model.reference[j] - model.reference[i];
        visit(model.bonds.weight[b], xi, Vector3(xi + u[j] - u[i]));
      }
    };
    Matrix3 s = Matrix3::Zero();
    over_bonds([&](double w, const Vector3& xi, const Vector3& y) {
      s += w / xi.squaredNorm() * y * xi.transpose();
    });
    const Eigen::JacobiSVD<Matrix3> svd(s, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 sign = Matrix3::Identity();
    sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    const Matrix3 r = svd.matrixU() * sign * svd.matrixV().transpose();
    double shape = 0, dilatation = 0;
    over_bonds([&](double w, const Vector3& xi, const Vector3& y) {
      const double x = xi.norm();
      if (law == "ordinary") {
        shape += w * std::pow(y.norm() / x - 1, 2);
        dilatation += w * (y.norm() / x - 1);
      } else {
        shape += w * (y - r * xi).squaredNorm() / (x * x);
        dilatation += w * ((r * xi).dot(y) / (x * x) - 1);
      }
    });
    // modulus is 2 mu or 2 b; coupling kappa / mu or (a - b) / b.
    sum += model.volume[i] * constants.modulus / 2 * (shape + constants.coupling * dilatation * dilatation);
  }
  return sum;
}

TEST(BrokenBonds, EnergyIsThatOfTheFormula) {
  const auto device = open_double();
  for (const double poisson : {0.1, 0.25, 0.4})
    for (const char* law : {"corotated", "ordinary"}) {
      Material material = material_of(law, 1e5, poisson);
      material.critical_stretch = critical;
      Broken body(*device, material);
      const std::vector<Vector3> u = noisy(body.stage.model, 0.1, 8);
      const double wanted = energy_by_hand(body.stage.model, law, u, body.broken);
      expect_below(std::string(law) + ", " + std::to_string(poisson).substr(0, 4) + ": energy off, relative",
                   std::abs(body.rig.energy(u) / wanted - 1), 1e-11);
    }
}

// Fourth-order differences of the energy and of the forces; the product is symmetric.
TEST(BrokenBonds, ForceIsTheGradientAndProductItsDerivative) {
  const auto device = open_double();
  for (const Breakable& one : breakable_materials()) {
    Broken body(*device, one.material);
    const std::size_t n = body.stage.model.count();
    const std::vector<Vector3> u = noisy(body.stage.model, 0.08, 9);
    double force_error = 0, product_error = 0, asymmetry = 0;
    for (unsigned trial = 0; trial < 4; ++trial) {
      std::mt19937 random(30 + trial);
      std::vector<Vector3> p(n, Vector3::Zero()), q(n);
      for (Vector3& v : q) v = random_vector(random);
      if (trial < 2)
        for (Vector3& v : p) v = random_vector(random);
      else // one particle alone: nothing averages out
        p[17 * trial] = random_vector(random);
      const double s = 2e-4 * spacing;
      const auto energy = [&](double t) { return body.rig.energy(plus(u, t * s, p)); };
      const double slope = (8 * (energy(1) - energy(-1)) - (energy(2) - energy(-2))) / (12 * s);
      const auto force = [&](double t) { return body.rig.forces(plus(u, t * s, p)); };
      std::vector<Vector3> change = plus(force(1), -1, force(-1));
      for (Vector3& v : change) v *= 8;
      change = plus(plus(change, -1, force(2)), 1, force(-2));
      for (Vector3& v : change) v /= 12 * s;
      const std::vector<Vector3> f = body.rig.forces(u);
      force_error = std::max(force_error, std::abs(slope + inner(f, p)) / (size_of(f) * size_of(p)));
      const std::vector<Vector3> hp = body.rig.product(p), hq = body.rig.product(q);
      product_error = std::max(product_error, size_of(plus(hp, 1, change)) / size_of(change));
      asymmetry = std::max(asymmetry, std::abs(inner(p, hq) - inner(q, hp)) / (size_of(p) * size_of(hq)));
    }
    expect_below(one.name + ": force against the energy", force_error, 1e-8);
    expect_below(one.name + ": product against the force", product_error, 1e-7);
    expect_below(one.name + ": |p.Hq - q.Hp|", asymmetry, 1e-12);
  }
}

class BrokenDevices : public OnEachDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, BrokenDevices, testing::ValuesIn(device_choices()), ChoiceName());

// Forces and products of each device against double: sums of some 20 bonds, each of differences of places of
// five spacings.
TEST_P(BrokenDevices, AgreeWithDouble) {
  const auto host = open_double();
  const auto open = device();
  const double epsilon = GetParam().epsilon();
  for (const Breakable& one : breakable_materials()) {
    Broken here(*open, one.material), exact(*host, one.material);
    const std::vector<Vector3> u = noisy(here.stage.model, 0.08, 9), p = noisy(here.stage.model, 0.3, 10);
    const auto off = [&](const std::vector<Vector3>& got, const std::vector<Vector3>& wanted) {
      return size_of(plus(got, -1, wanted)) / size_of(wanted) / epsilon;
    };
    const std::vector<Vector3> f = here.rig.forces(u), wanted = exact.rig.forces(u);
    expect_below(one.name + ": forces, roundings", off(f, wanted), 40);
    expect_below(one.name + ": product, roundings", off(here.rig.product(p), exact.rig.product(p)), 40);
    EXPECT_NEAR(here.rig.energy(u), exact.rig.energy(u), 200 * epsilon * exact.rig.energy(u)) << one.name;
  }
}

// Particles that share no bond any more do not feel each other: moved apart, every bit of the forces is the
// same.
TEST_P(BrokenDevices, ContributeNothing) {
  const auto open = device();
  for (const Breakable& one : breakable_materials()) {
    const Stage stage = breakable_stage(one.material, spacing);
    SolveRig rig(*open, stage.scene, stage.model);
    std::vector<Vector3> u = noisy(stage.model, 0.03, 5);
    const auto parted = [&](const Vector3& by) {
      std::vector<Vector3> moved(u);
      for (std::size_t i = 0; i < u.size(); ++i)
        if (stage.model.reference[i].x() > 2.5 * spacing) moved[i] += by;
      return moved;
    };
    const std::vector<Vector3> apart = parted({spacing, 0, 0});
    rig.forces(apart);
    rig.break_bonds(apart);
    // Of the half that stays: the other's place is no longer read.
    const std::vector<Vector3> near = forces_anew(*open, rig, parted({spacing, 0, 0})),
                               far = forces_anew(*open, rig, parted({0, 0, 7}));
    double worst = 0, size = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      size = std::max(size, far[i].norm());
      if (stage.model.reference[i].x() < 2.5 * spacing) worst = std::max(worst, (near[i] - far[i]).norm());
    }
    EXPECT_EQ(worst, 0) << one.name;
    EXPECT_GT(size, 0) << one.name;
  }
}

// Dropping rows of padding moves bonds and their strengths, and changes no bit of any sum.
TEST_P(BrokenDevices, RepackingChangesNoBit) {
  const auto open = device();
  for (const Breakable& one : breakable_materials()) {
    const Stage stage = breakable_stage(one.material, spacing);
    SolveRig rig(*open, stage.scene, stage.model);
    // Two halves, and noise that breaks bonds here and there.
    std::vector<Vector3> apart = noisy(stage.model, 0.25, 7);
    for (std::size_t i = 0; i < apart.size(); ++i)
      if (stage.model.reference[i].x() > 2.5 * spacing) apart[i].x() += spacing;
    rig.forces(apart);
    rig.break_bonds(apart);
    const std::vector<Vector3> u = noisy(stage.model, 0.1, 9), p = noisy(stage.model, 0.3, 10);
    const auto all = [&] {
      std::vector<Vector3> values = forces_anew(*open, rig, u);
      const std::vector<Vector3> product = rig.product(p);
      values.insert(values.end(), product.begin(), product.end());
      values.emplace_back(rig.energy(u), 0, 0); // from where forces_anew() went
      return values;
    };
    const std::vector<std::uint32_t> rows = open->download_uint(rig.state().slice_begin);
    const std::vector<Vector3> before = all();
    rig.failure()->repack();
    const std::vector<std::uint32_t> packed = open->download_uint(rig.state().slice_begin);
    EXPECT_LT(packed.back(), rows.back()) << one.name << ": nothing was dropped";
    EXPECT_EQ(before, all()) << one.name;
    rig.failure()->repack(); // and again there is nothing to drop
    EXPECT_EQ(packed, open->download_uint(rig.state().slice_begin)) << one.name;
  }
}

// Damage: a half of a full neighbourhood is lost where a plane parts it.
TEST_P(BrokenDevices, DamageIsTheShareOfWeightsThatIsGone) {
  const auto open = device();
  Material material = material_of("ordinary", 1e5, 0.3);
  material.critical_stretch = critical;
  const Stage stage = breakable_stage(material, spacing);
  SolveRig rig(*open, stage.scene, stage.model);
  const std::vector<Vector3> u = noisy(stage.model, 0.3, 7);
  const std::vector<bool> broken = broken_by(stage.model, u);
  for (const double damage : rig.failure()->damage()) EXPECT_NEAR(damage, 0, 1e-12);
  rig.forces(u);
  rig.break_bonds(u);
  const std::vector<double> damage = rig.failure()->damage();
  for (std::uint32_t i = 0; i < stage.model.count(); ++i) {
    double gone = 0;
    for (std::uint32_t b = stage.model.bonds.begin[i]; b < stage.model.bonds.begin[i + 1]; ++b)
      if (broken[b]) gone += stage.model.bonds.weight[b];
    EXPECT_NEAR(damage[i], gone, 40 * GetParam().epsilon()) << i;
  }
}

} // namespace
} // namespace pliant::test
