// Cells, lists of contacts, and forces between particles.
#include "tests/contact/world.h"

#include "backends/openmp/device.h"

#include <algorithm>
#include <cmath>

namespace pliant::test {
namespace {

// Two bodies that overlap, with particles in one place; spacing 0.1, so d = 0.09 and reach 0.12.
World cloud(std::size_t each, double size, unsigned seed) {
  World world;
  world.scene.contact.bodies = true;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-size, size), small(-0.01, 0.01), k(500, 2000);
  for (int body = 0; body < 2; ++body) {
    world.add_body({0.3 * body, 0.1, -0.2});
    for (std::size_t i = 0; i < each; ++i)
      world.add({coordinate(random), coordinate(random), coordinate(random)},
                {small(random), small(random), small(random)}, k(random));
  }
  for (std::size_t i = 0; i < 5; ++i) {
    world.model.position[each + i] = world.model.position[i];
    world.displacement[each + i] = world.displacement[i];
  }
  return world;
}

Vector3 now(const World& world, std::size_t i) {
  return world.model.position[i] + world.displacement[i];
}

class Pairs : public ContactTest {};

TEST_P(Pairs, OrderIsThatOfAStableSortByCell) {
  const World world = cloud(3001, 0.5, 11);
  Bench bench(*device, world);
  const auto cell_of = device->download_uint(bench.contacts.buffer("cell_of"));
  const auto begin = device->download_uint(bench.contacts.buffer("cell_begin"));
  std::vector<std::uint32_t> expected(world.count());
  for (std::uint32_t i = 0; i < expected.size(); ++i) expected[i] = i;
  std::stable_sort(expected.begin(), expected.end(), [&](auto a, auto b) { return cell_of[a] < cell_of[b]; });
  EXPECT_EQ(device->download_uint(bench.contacts.buffer("sorted")), expected);
  ASSERT_EQ(begin.size(), bench.contacts.plan().cells + 1u);
  EXPECT_EQ(begin.back(), world.count());
  for (std::uint32_t c = 0; c + 1 < begin.size(); ++c)
    for (std::uint32_t place = begin[c]; place < begin[c + 1]; ++place)
      ASSERT_EQ(cell_of[expected[place]], c);
}

TEST_P(Pairs, ListsAreThoseOfAllPairs) {
  const World world = cloud(700, 0.5, 5);
  Bench bench(*device, world);
  const auto lists = bench.lists();
  EXPECT_EQ(bench.contacts.overflow().contacts, 0u);
  const double reach = bench.contacts.plan().reach;
  std::size_t found = 0;
  for (std::uint32_t i = 0; i < world.count(); ++i) {
    EXPECT_TRUE(std::is_sorted(lists[i].begin(), lists[i].end()));
    for (std::uint32_t j = 0; j < world.count(); ++j) {
      const double r = (now(world, j) - now(world, i)).norm();
      if (j == i || std::abs(r - reach) < 1e-5) continue;
      const bool listed = std::count(lists[i].begin(), lists[i].end(), j) == 1;
      ASSERT_EQ(listed, r < reach && world.model.body[i] != world.model.body[j])
          << i << " " << j << " at " << r;
      found += listed;
    }
  }
  EXPECT_GT(found, 200u);
}

TEST_P(Pairs, ForcesAreTheGradientAndAddUpToZero) {
  World world = cloud(500, 0.4, 3);
  world.scene.contact.friction = 0;
  Bench bench(*device, world);
  const auto forces = bench.forces();
  const double d = bench.contacts.plan().distance;
  Vector3 sum = Vector3::Zero();
  double most = 0;
  const auto lists = bench.lists();
  for (std::size_t i = 0; i < world.count(); ++i) {
    Vector3 expected = Vector3::Zero();
    double diagonal = world.stiffness[i];
    bool coincident = false;
    for (const std::uint32_t j : lists[i]) {
      const Vector3 y = now(world, j) - now(world, i);
      const double r = y.norm(), k = std::min(world.stiffness[i], world.stiffness[j]) / 2;
      if (r >= d) continue;
      diagonal += k;
      coincident = coincident || r < 1e-9;
      if (r > 1e-9) expected -= k * (d - r) * y / r;
    }
    sum += vector_of(forces[i]);
    most = std::max(most, vector_of(forces[i]).norm());
    EXPECT_NEAR(forces[i].w, diagonal, 50 * epsilon * diagonal);
    // Direction of a short y: 1e-3 m out of coordinates of size one loses three digits.
    if (!coincident) {
      EXPECT_LT((vector_of(forces[i]) - expected).norm(), 4e4 * epsilon) << i;
    }
  }
  EXPECT_GT(most, 10);
  EXPECT_LT(sum.norm(), 1e3 * epsilon * most);
  const Vector3 a = vector_of(forces[0]);
  EXPECT_TRUE(a.allFinite());
}

TEST_P(Pairs, CoincidentParticlesPart) {
  World world;
  world.scene.contact.bodies = true;
  for (int body = 0; body < 2; ++body) {
    world.add_body(Vector3::Zero());
    world.add({0.2, 0.1, 0.3});
  }
  Bench bench(*device, world);
  const auto forces = bench.forces();
  EXPECT_EQ((vector_of(forces[0]) + vector_of(forces[1])).norm(), 0);
  EXPECT_NEAR(vector_of(forces[0]).norm(), 500 * bench.contacts.plan().distance, 500 * epsilon);
  EXPECT_EQ(bench.touched(), (std::vector<std::uint32_t>{1, 1}));
}

TEST_P(Pairs, FrictionIsCoulombsAndMutual) {
  for (const double slide : {0.001, 0.05}) {
    World world;
    world.scene.contact.bodies = true;
    world.add_body(Vector3::Zero());
    world.add({0, 0, 0}, {slide, 0, 0});
    world.add_body(Vector3::Zero());
    world.add({slide, 0.08, 0}); // straight above at the end of the step
    Bench bench(*device, world);
    const auto forces = bench.forces();
    const double normal = 500 * 0.01;
    EXPECT_NEAR(forces[1].y, normal, 2000 * epsilon);
    EXPECT_NEAR(forces[0].x, -std::min(500 * slide, 0.3 * normal), 2000 * epsilon);
    EXPECT_EQ(forces[0].x, -forces[1].x);
  }
}

TEST_P(Pairs, BondedNeighboursDoNotTouch) {
  // Particles 0, 1, 2 in a row at 0.08; 0-1 and 1-2 are bonded. The end is folded back: 2 lies 0.05 from 0.
  World world;
  world.scene.contact.self = true;
  world.add({0, 0, 0});
  world.add({0.08, 0, 0});
  world.add({0.0, 0.05, 0});
  world.model.laws.push_back({Law::corotated, 0, 3, 0});
  world.slice_begin = {0, 2};
  world.bond.assign(64, 0);
  for (std::uint32_t lane = 0; lane < 16; ++lane) world.bond[lane] = world.bond[32 + lane] = lane;
  world.bond[0] = 1;
  world.bond[1] = 0;
  world.bond[32 + 1] = 2;
  world.bond[2] = 1;
  Bench bench(*device, world);
  const auto lists = bench.lists();
  EXPECT_EQ(lists[0], std::vector<std::uint32_t>{2});
  EXPECT_TRUE(lists[1].empty());
  EXPECT_EQ(lists[2], std::vector<std::uint32_t>{0});
  world.model.bodies[0].self_contact = false;
  EXPECT_FALSE(plan_contacts(world.scene, world.model).any());
}

TEST_P(Pairs, OverfullListsStayMutualAndAreCounted) {
  World world = cloud(200, 0.06, 9); // hundreds within reach
  Bench bench(*device, world);
  const ContactOverflow overflow = bench.contacts.overflow();
  EXPECT_GT(overflow.contacts, 1000u);
  EXPECT_GT(overflow.particles, 100u);
  const auto lists = bench.lists();
  std::size_t kept = 0;
  for (std::uint32_t i = 0; i < world.count(); ++i)
    for (const std::uint32_t j : lists[i]) {
      EXPECT_EQ(std::count(lists[j].begin(), lists[j].end(), i), 1) << i << " " << j;
      ++kept;
    }
  EXPECT_GT(kept, 100u);
  Vector3 sum = Vector3::Zero();
  double all = 0;
  for (const auto& f : bench.forces()) sum += vector_of(f), all += vector_of(f).norm();
  EXPECT_LT(sum.norm(), 20 * epsilon * all);
}

TEST_P(Pairs, LostParticlesHarmNobody) {
  World world = cloud(40, 0.1, 2);
  world.displacement[3] = Vector3::Constant(std::nan(""));
  world.displacement[4] = Vector3::Constant(1e30);
  Bench bench(*device, world);
  const auto forces = bench.forces();
  for (std::size_t i = 5; i < world.count(); ++i) EXPECT_TRUE(vector_of(forces[i]).allFinite()) << i;
  EXPECT_EQ(device->download_uint(bench.contacts.buffer("cell_begin")).back(), world.count());
}

TEST_P(Pairs, SameAsTheProcessor) {
  const World world = cloud(2000, 0.45, 21);
  Bench bench(*device, world);
  const auto cpu = openmp::make_device(Precision::single_precision, 1);
  Bench reference(*cpu, world);
  if (GetParam().precision == Precision::single_precision) {
    for (const char* name :
         {"cell_of", "cell_begin", "sorted"}) // integers and single roundings: the same bits
      EXPECT_EQ(device->download_uint(bench.contacts.buffer(name)),
                cpu->download_uint(reference.contacts.buffer(name)))
          << name;
    EXPECT_EQ(bench.lists(), reference.lists());
  }
  const auto a = bench.forces(), b = reference.forces();
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (i % 2000 < 5) continue; // in one place: beyond d in neither, but double may order them otherwise
    worst = std::max(worst, (vector_of(a[i]) - vector_of(b[i])).norm());
  }
  // Float coordinates of size one over distances of 1e-3 m: 2e4 units of rounding times N/m over m.
  EXPECT_LT(worst, 4e4 * 0x1p-23);
}

INSTANTIATE_TEST_SUITE_P(Devices, Pairs, testing::ValuesIn(device_choices()),
                         [](const auto& one) { return ChoiceName()(one); });

TEST(Grid, SameForEveryNumberOfThreads) {
  const World world = cloud(20000, 0.9, 1);
  const auto one = openmp::make_device(Precision::single_precision, 1);
  const auto two = openmp::make_device(Precision::single_precision, 2);
  const auto five = openmp::make_device(Precision::single_precision, 5);
  Bench a(*one, world), b(*two, world), c(*five, world);
  for (const char* name : {"sorted", "cell_begin", "contact"}) {
    EXPECT_EQ(one->download_uint(a.contacts.buffer(name)), two->download_uint(b.contacts.buffer(name)))
        << name;
    EXPECT_EQ(one->download_uint(a.contacts.buffer(name)), five->download_uint(c.contacts.buffer(name)))
        << name;
  }
  const auto fa = a.forces(), fb = b.forces();
  for (std::size_t i = 0; i < fa.size(); ++i) ASSERT_EQ(vector_of(fa[i]), vector_of(fb[i]));
}

} // namespace
} // namespace pliant::test
