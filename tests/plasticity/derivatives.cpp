// Law M2 with rest lengths of each end's own: force against differences of the energy, its derivative
// against differences of the force, every device against double; and what a return does to the energy.
#include "tests/plasticity/material_point.h"

namespace pliant::test {
namespace {

constexpr double spacing = 0.125;

struct World {
  Stage stage;
  std::vector<Vector3> u;
  World() : stage(lattice(5, 4, 6, spacing), spacing, plastic_material(1e6, 0.35, 1e3, 30), 1. / 64) {
    stage.scene.solver.method = "newton";
    stage.scene.solver.preconditioner = "diagonal";
    std::mt19937 random(11);
    for (std::size_t i = 0; i < stage.model.count(); ++i)
      u.push_back((0.05 * spacing * random_vector(random)).cast<float>().cast<double>());
  }
  /// 0.8 to 1.2, one for each direction of a bond, in both rows where it stands.
  std::vector<double> rest() const {
    const SlicedBonds bonds = slice_bonds(stage.model);
    std::vector<double> values(2 * bonds.neighbour.size(), 1.0);
    const auto of = [](std::uint32_t i, std::uint32_t j) {
      return static_cast<double>(static_cast<float>(0.8 + 0.4 * ((31 * i + 17 * j) % 101) / 100));
    };
    for (std::size_t e = 0; e < bonds.neighbour.size(); ++e) {
      const auto i =
          static_cast<std::uint32_t>(std::upper_bound(bonds.slice_begin.begin(), bonds.slice_begin.end(), e) -
                                     bonds.slice_begin.begin() - 1) *
              slice_width +
          static_cast<std::uint32_t>(e % slice_width);
      if (bonds.neighbour[e] == i || bonds.weight_out[e] + bonds.weight_in[e] == 0) continue;
      const std::size_t at = e / slice_width * 2 * slice_width + e % slice_width;
      values[at] = of(i, bonds.neighbour[e]);
      values[at + slice_width] = of(bonds.neighbour[e], i);
    }
    return values;
  }
};

class Rig : public SolveRig {
public:
  Rig(Device& device, const World& world)
      : SolveRig(device, world.stage.scene, world.stage.model), device_(device) {
    device_.upload(state().rest, world.rest());
  }
  double energy(const std::vector<Vector3>& u) {
    forces(u);
    double sum = 0;
    for (const double e : device_.download_real(state().energy)) sum += e;
    return sum;
  }

private:
  Device& device_;
};

TEST(PlasticLaw, ForceIsTheGradientAndTheProductItsDerivative) {
  const auto open = open_double();
  const World world;
  Rig rig(*open, world);
  std::mt19937 random(3);
  std::vector<Vector3> v, w;
  for (std::size_t i = 0; i < world.u.size(); ++i)
    v.push_back(random_vector(random)), w.push_back(random_vector(random));
  const double h = 1e-6 * spacing;
  const double slope = (rig.energy(plus(world.u, h, v)) - rig.energy(plus(world.u, -h, v))) / (2 * h);
  const std::vector<Vector3> force = rig.forces(world.u);
  // Differences: h^2 of the third derivative, and the rounding of the energy over h.
  expect_below("|dE + f . v| / |f . v|", std::abs(slope + inner(force, v)) / std::abs(inner(force, v)), 1e-7);
  Vector3 total = Vector3::Zero();
  for (const Vector3& f : force) total += f;
  expect_below("sum of forces, of the largest", total.norm() / largest(force), 1e-12);
  const std::vector<Vector3> up = rig.forces(plus(world.u, h, v)), down = rig.forces(plus(world.u, -h, v));
  std::vector<Vector3> wanted = plus(down, -1, up); // -df
  for (std::size_t i = 0; i < wanted.size(); ++i)
    wanted[i] = wanted[i] / (2 * h) + world.stage.model.mass[i] * 64 * 64 * v[i];
  rig.forces(world.u);
  const std::vector<Vector3> product = rig.product(v);
  expect_below("|product - difference| / |product|", largest_difference(product, wanted) / largest(product),
               1e-7);
  rig.forces(world.u);
  const double other = inner(rig.product(w), v);
  expect_below("symmetry of the product", std::abs(inner(product, w) - other) / std::abs(other), 1e-12);
}

class PlasticLawOn : public OnEachDevice {};

TEST_P(PlasticLawOn, AgreesWithDouble) {
  const auto open = device(), host = open_double();
  const World world;
  Rig rig(*open, world), exact(*host, world);
  const auto measured = [&](const std::vector<Vector3>& got, const std::vector<Vector3>& wanted) {
    double size = 0, error = 0;
    for (std::size_t i = 0; i < got.size(); ++i)
      size += wanted[i].squaredNorm(), error += (got[i] - wanted[i]).squaredNorm();
    return std::sqrt(error / size) / GetParam().epsilon();
  };
  // As those of the law without plasticity (tests/kernels/derivative_test.cpp), strains here being larger.
  expect_below("force, roundings", measured(rig.forces(world.u), exact.forces(world.u)), 10);
  expect_below("energy, roundings",
               std::abs(rig.energy(world.u) / exact.energy(world.u) - 1) / GetParam().epsilon(), 10);
  rig.forces(world.u), exact.forces(world.u);
  expect_below("product, roundings", measured(rig.product(world.u), exact.product(world.u)), 10);
}

INSTANTIATE_TEST_SUITE_P(Plasticity, PlasticLawOn, testing::ValuesIn(device_choices()), ChoiceName());

// In a state without any symmetry: every particle is on its surface or inside it afterwards, the work is
// that of the stress that stays, no particle's share of it is negative, and a second return finds nothing to
// do. With shares alpha, beta of the strains flowing, of energies D + I before (1 - beta)^2 D + (1 - alpha)^2
// I are left, and the stress that stays has done 2 beta (1 - beta) D + 2 alpha (1 - alpha) I on the way.
TEST(PlasticReturn, WorkIsThatOfTheStressThatStays) {
  const auto open = open_double();
  for (const double friction : {0.0, 30.0})
    for (const double cohesion : {0.0, 2e3, 2e4}) {
      if (cohesion + friction == 0) continue;
      World world;
      world.stage.scene.materials[0].plastic = {true, cohesion, friction * std::acos(-1.0) / 180,
                                                friction == 0 ? 1e4 : 0};
      Rig rig(*open, world);
      PlasticFlow flow(*open, world.stage.scene, world.stage.model, rig.plan, rig.state(),
                       world.stage.model.spacing / reference_grid);
      const double before = rig.energy(world.u);
      const std::vector<double> each = open->download_real(rig.state().energy);
      flow.flow();
      const double after = rig.energy(world.u);
      const std::vector<double> left = open->download_real(rig.state().energy);
      const auto rows = open->download_real4(rig.state().flow);
      double work = 0, total = 0, worst = 0, least = 0;
      std::size_t flowing = 0;
      for (std::size_t i = 0; i < each.size(); ++i) {
        work += rows[2 * i].y;
        least = std::min(least, rows[2 * i].y);
        const double keeps_iso = rows[2 * i + 1].y, keeps_dev = rows[2 * i + 1].z;
        const double wanted = keeps_iso < 1 ? keeps_iso > 0 ? 2 * left[i] * (1 - keeps_iso) / keeps_iso : 0
                                            : (each[i] - left[i]) * 2 * keeps_dev / (1 + keeps_dev);
        total += wanted;
        worst = std::max(worst, std::abs(wanted - rows[2 * i].y) / each[i]);
        flowing += rows[2 * i].w > 0;
      }
      std::printf("friction %g, cohesion %g: %zu of %zu flow, %.4f of the energy goes\n", friction, cohesion,
                  flowing, each.size(), work / before);
      EXPECT_GT(flowing, 0u);
      EXPECT_GE(least, 0);
      EXPECT_LE(work, before - after);
      expect_below("of each particle, |work - that of its stress| / energy", worst, 1e-12);
      expect_below("|work - that of the stress| / energy", std::abs(total - work) / before, 1e-12);
      flow.flow();
      double again = 0;
      const auto twice = open->download_real4(rig.state().flow);
      for (std::size_t i = 0; i < each.size(); ++i) again += twice[2 * i].y;
      expect_below("work of a second return, of the first", (again - work) / work, 1e-12);
    }
}

} // namespace
} // namespace pliant::test
