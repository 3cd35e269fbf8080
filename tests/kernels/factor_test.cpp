// factor_up, factor_down, factor_dot: a solve with the constant matrix's factor, against the dense matrix;
// and the order of elimination that it rests on.
#include "engine/solver/direct.h"
#include "tests/support/kernel_particles.h"
#include "tests/support/solve_rig.h"

#include <Eigen/Dense>

#include <set>

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FactorSolve);

constexpr double spacing = 0.1, step = 0.01;

/// A bar, a plate that does not touch it, and a particle alone: separators with nothing in them, and several.
Stage scattered() {
  Points points = lattice(14, 5, 4, spacing);
  for (const Vector3& x : lattice(9, 9, 1, spacing)) points.push_back(x + Vector3(2, 0.3, 0.1));
  points.push_back(Vector3(-3, 1, 2));
  Stage stage(points, spacing, material_of("corotated", 1e5, 0.3), step);
  stage.scene.solver.method = "newton"; // what the rig asks for
  stage.scene.solver.preconditioner = "direct";
  return stage;
}

/// One layer held for ever, and one until it is set free.
void hold_ends(Stage& stage) {
  stage.model.motions.resize(2);
  stage.model.motions[1].release = true;
  stage.model.motions[1].end = 0.5;
  for (std::uint32_t i = 0; i < stage.model.count(); ++i) {
    const double x = stage.model.position[i].x();
    if (std::abs(x) < 0.01) stage.model.held.push_back({i, 0});
    if (std::abs(x - 1.3) < 0.01) stage.model.held.push_back({i, 1});
  }
}

/// M / h^2 + L, written out; of particles that are held for ever the diagonal only.
Eigen::MatrixXd constant_matrix(const Model& model) {
  const auto n = static_cast<Eigen::Index>(model.count());
  std::vector<bool> never_free(model.count(), false);
  for (const Held& held : model.held)
    if (!model.motions[held.motion].release.value_or(false)) never_free[held.particle] = true;
  const std::vector<double> stiffness = diagonal_stiffness(model);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    a(i, i) = model.mass[i] / (step * step) + stiffness[i];
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model.bonds.neighbour[b];
      if (never_free[i] || never_free[j]) continue;
      const double x2 = (model.reference[j] - model.reference[i]).squaredNorm();
      const double k = bond_bound(model, i, b) * model.constants[model.material[i]].modulus *
                       model.volume[i] * model.bonds.weight[b] / x2;
      a(i, j) -= k, a(j, i) -= k;
    }
  }
  return a;
}

std::vector<Vector3> random_field(std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-1, 1);
  std::vector<Vector3> field(count);
  for (Vector3& v : field) v = Vector3(draw(random), draw(random), draw(random));
  return field;
}

TEST_P(FactorSolve, SolvesTheConstantMatrix) {
  for (const bool held : {false, true}) {
    Stage stage = scattered();
    if (held) hold_ends(stage);
    const Model& model = stage.model;
    const auto device = GetParam().open();
    SolveRig rig(*device, stage.scene, model);
    std::vector<Vector3> r = random_field(model.count());
    for (const Held& one : model.held) r[one.particle].setZero();
    rig.forces(std::vector<Vector3>(model.count(), Vector3::Zero()));
    rig.refresh();
    const std::vector<Vector3> z = rig.precondition(r);
    const Eigen::MatrixXd a = constant_matrix(model);
    Eigen::MatrixXd right(model.count(), 3);
    for (std::size_t i = 0; i < model.count(); ++i) right.row(static_cast<Eigen::Index>(i)) = r[i];
    Eigen::MatrixXd wanted = a.ldlt().solve(right);
    for (const Held& one : model.held) wanted.row(one.particle).setZero();
    double off = 0, product = 0;
    for (std::size_t i = 0; i < model.count(); ++i) {
      off += (z[i] - Vector3(wanted.row(static_cast<Eigen::Index>(i)))).squaredNorm();
      product += r[i].dot(z[i]);
    }
    // A solve loses what the condition number, (1 + eta) at most, takes of the precision.
    const double eta = step * step * diagonal_stiffness(model)[5] / model.mass[5];
    EXPECT_LE(std::sqrt(off), (1 + eta) * GetParam().epsilon() * wanted.norm()) << (held ? "held" : "free");
    double sum = 0;
    for (const Real4<double>& one :
         device->download_real4(rig.state().solve_partial, 0, (model.count() + 127) / 128))
      sum += one.x;
    EXPECT_NEAR(sum, product, 20 * GetParam().epsilon() * product);
  }
}

// Sums are made in one order: threads share fronts, never a sum.
TEST(FactorOrder, ThreadsChangeNoBit) {
  const Stage stage = scattered();
  std::vector<Vector3> found[2];
  for (const unsigned threads : {1u, 2u}) {
    const auto device = open_device({"openmp", Precision::single_precision, threads});
    SolveRig rig(*device, stage.scene, stage.model);
    rig.forces(std::vector<Vector3>(stage.model.count(), Vector3::Zero()));
    rig.refresh();
    found[threads - 1] = rig.precondition(random_field(stage.model.count()));
  }
  EXPECT_EQ(found[0], found[1]);
}

TEST(Dissection, EliminatesEachFreeParticleOnceAndLeavesTheRestForLater) {
  Stage stage = scattered();
  hold_ends(stage);
  const Model& model = stage.model;
  const Dissection d = dissect(model);
  std::size_t never_free = 0;
  for (const Held& held : model.held) never_free += held.motion == 0;
  ASSERT_GT(never_free, 0u);
  EXPECT_EQ(d.order.size(), model.count() - never_free);
  std::set<std::uint32_t> seen(d.order.begin(), d.order.end());
  EXPECT_EQ(seen.size(), d.order.size());
  std::uint32_t next = 0;
  for (std::size_t f = 0; f < d.fronts.size(); ++f) {
    const Front& front = d.fronts[f];
    EXPECT_EQ(front.first, next);
    next += front.columns;
    for (std::uint32_t r = front.row_begin; r < front.row_end; ++r) {
      EXPECT_GE(d.row[r], front.first + front.columns);
      EXPECT_TRUE(r == front.row_begin || d.row[r - 1] < d.row[r]);
    }
    for (const std::int32_t c : front.child) {
      if (c < 0) continue;
      const Front& child = d.fronts[static_cast<std::size_t>(c)];
      EXPECT_LT(static_cast<std::size_t>(c), f);
      EXPECT_LT(child.level, front.level);
      for (std::uint32_t r = child.row_begin; r < child.row_end; ++r) { // all of them are this front's
        const std::uint32_t place = d.row[r];
        const bool own = place >= front.first && place < front.first + front.columns;
        EXPECT_TRUE(
            own || std::binary_search(d.row.begin() + front.row_begin, d.row.begin() + front.row_end, place));
      }
    }
  }
  EXPECT_EQ(next, d.order.size());
}

// What cutting is for: a cube's factor grows with n^(4/3) (George 1973), a dense one with n^2.
TEST(Dissection, FactorsOfCubesGrowAsCutsDo) {
  const auto entries = [](int side) {
    return dissect(
               Stage(lattice(side, side, side, spacing), spacing, material_of("ordinary", 1e5, 0.25), step)
                   .model)
        .entries();
  };
  const double small = entries(8), large = entries(16);
  EXPECT_LT(std::log2(large / small), 3 * 1.6); // n^(4/3) is 4, and small cubes are still on their way to it
}

} // namespace
} // namespace pliant::test
