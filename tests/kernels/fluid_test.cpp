// Fluids: cells, lists of neighbours, and the sweeps of the density constraint. What else a step is made of:
// fluid_step_test.cpp.
#include "engine/model/smoothing.h"
#include "kernels/fluid_lambda.h"
#include "kernels/fluid_shift.h"
#include "shaders/common/fluid.glsl"
#include "tests/support/fluids.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

class FluidKernels : public testing::TestWithParam<DeviceChoice> {};
INSTANTIATE_TEST_SUITE_P(Devices, FluidKernels, testing::ValuesIn(device_choices()), ChoiceName());

constexpr double spacing = 0.125;

Points cloud(std::size_t count, const Vector3& low, const Vector3& high, unsigned seed) {
  Random random(seed);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 unit = (random.vector() + Vector3::Ones()) / 2;
    points.push_back(low + rounded(Vector3(unit.cwiseProduct(high - low))));
  }
  return points;
}

/// All pairs nearer than the reach, but for those that rounding may put on either side of it.
void expect_all_pairs(const DeviceChoice& choice, const Stage& stage, const char* what) {
  SCOPED_TRACE(what);
  const auto device = open_alone(choice);
  Simulation simulation(*device, stage.scene, stage.model);
  simulation.step();
  EXPECT_EQ(simulation.take_statistics().back().neighbours_dropped, 0u);
  const auto lists = neighbour_lists(simulation);
  const double reach = simulation.fluid()->plan().model.reach;
  std::size_t found = 0;
  for (std::uint32_t i = 0; i < lists.size(); ++i) {
    ASSERT_EQ(std::adjacent_find(lists[i].begin(), lists[i].end()), lists[i].end()) << "twice in a list";
    for (std::uint32_t j = 0; j < lists.size(); ++j) {
      const double r = image(stage.scene, stage.model.position[i] - stage.model.position[j]).norm();
      if (i == j || std::abs(r / reach - 1) < 1e-5) continue;
      const bool listed = std::binary_search(lists[i].begin(), lists[i].end(), j);
      if (listed != (r < reach)) FAIL() << i << " and " << j << " at " << r / reach << " of the reach";
      found += listed;
    }
  }
  EXPECT_GT(found, lists.size());
}

TEST_P(FluidKernels, ListsAreThoseOfAllPairs) {
  const auto made = [](const Points& points, unsigned room, unsigned dimension = 3) {
    Stage stage = fluid_stage(points, spacing, 1e-3, dimension);
    stage.scene.fluid.neighbours = room;
    return stage;
  };
  expect_all_pairs(GetParam(), made(cloud(700, {-0.6, -0.5, 0}, {0.6, 0.5, 0.7}, 1), 128), "a cloud");
  Stage even =
      fluid_stage(lattice(8, 7, 6, spacing), spacing, 1e-3); // with the room that lists have by default
  expect_all_pairs(GetParam(), even, "a lattice");
  // Each list holds everybody, and more than a cell's surroundings have room for on the CPU.
  expect_all_pairs(GetParam(), made(cloud(1100, {0, 0, 0}, {0.15, 0.12, 0.1}, 2), 1104), "a crowd");
  Points far = cloud(250, {0, 0, 0}, {0.5, 0.5, 0.5}, 3); // cells repeat: these share some with the rest
  for (const Vector3& p : cloud(250, {40, -70, 90}, {40.5, -69.5, 90.5}, 4)) far.push_back(p);
  expect_all_pairs(GetParam(), made(far, 256), "two clouds far apart");
  expect_all_pairs(GetParam(), made(cloud(500, {0, 0, 0}, {2, 2, 0}, 5), 64, 2), "a plane");
  const Vector3 low(-0.5, 0, 0.25), high(0.5, 0.9, 1.125);
  for (const std::array<bool, 3> periodic :
       {std::array{true, true, true}, {true, false, true}, {false, true, false}}) {
    Stage box = made(cloud(600, low, high, 6), 256);
    repeat(box.scene, low, high, periodic);
    expect_all_pairs(GetParam(), box, "a box that repeats");
  }
}

// What a list has no room for is counted, and the rest of the list is whole.
TEST_P(FluidKernels, FullListsAreCounted) {
  Stage stage = fluid_stage(cloud(200, {0, 0, 0}, {0.1, 0.1, 0.1}, 7), spacing, 1e-3); // all near all
  stage.scene.fluid.neighbours = 40;
  const auto device = open_alone(GetParam());
  Simulation simulation(*device, stage.scene, stage.model);
  simulation.step();
  const StepStatistics row = simulation.take_statistics().back();
  EXPECT_EQ(row.lists_full, 200u);
  EXPECT_EQ(row.neighbours_dropped, 200u * (199 - 40));
}

/// Places with random masses, their lists by all pairs, and what the sweeps read beside them.
struct Sweep {
  std::size_t count = 0, places = 0;
  Smoothing smoothing{2.1 * spacing, 3};
  Points at;
  std::vector<double> mass; ///< negative: of a ghost
  double rest = 0;
  Vector3 period = Vector3::Zero();
  std::vector<std::vector<std::size_t>> near;
  std::vector<double> wall; ///< groups of four: gradient of what walls add, 1/m, and that; empty: no walls
  Values in;

  explicit Sweep(unsigned seed, bool repeats = false) {
    Random random(seed);
    at = lattice(6, 5, 5, spacing);
    count = at.size();
    places = (count + 15) / 16 * 16;
    smoothing.support = rounded(smoothing.support);
    rest = rounded(smoothing.lattice_density(spacing));
    for (std::size_t i = 0; i < count; ++i) {
      at[i] = rounded(Vector3(0.93 * at[i] + random.vector(0.2 * spacing)));
      mass.push_back(rounded((i % 7 == 3 ? -1 : 1) * (1 + 0.5 * random())));
    }
    if (repeats) period = {0.75, 0, 0.625};
    fill();
  }
  Vector3 between(std::size_t i, std::size_t j) const {
    Vector3 d = at[i] - at[j];
    for (int a = 0; a < 3; ++a)
      if (period[a] > 0) d[a] -= period[a] * std::round(d[a] / period[a]);
    return d;
  }
  double density_error(std::size_t i) const {
    // The kernels get their factors rounded to a float.
    const double factor = rounded(smoothing.spline()) / smoothing.spline();
    double sum = std::abs(mass[i]) * factor * smoothing.spline_value(0);
    for (std::size_t j = 0; j < count; ++j)
      if (j != i) sum += std::abs(mass[j]) * factor * smoothing.spline_value(between(i, j).norm());
    return sum / rest - 1 + (wall.empty() ? 0 : wall[4 * i + 3]);
  }
  /// grad_k C_i
  Vector3 gradient(std::size_t k, std::size_t i) const {
    const double factor = rounded(smoothing.spline_gradient()) / smoothing.spline_gradient();
    const auto slope = [&](std::size_t j) -> Vector3 { // grad_i W_ij
      const Vector3 d = between(i, j);
      const double r = d.norm();
      return r > 0 && r < smoothing.support ? Vector3(factor * smoothing.spline_derivative(r) / r * d)
                                            : Vector3(Vector3::Zero());
    };
    if (k != i) return -std::abs(mass[k]) / rest * slope(k);
    Vector3 sum = wall.empty() ? Vector3(Vector3::Zero()) : vector_at(wall, i);
    for (std::size_t j = 0; j < count; ++j)
      if (j != i) sum += std::abs(mass[j]) / rest * slope(j);
    return sum;
  }

  void put_walls() {
    Random random(18);
    wall = random_groups(random, places, 0.25);
    in["walls"] = {1};
    in["fluid_wall"] = wall;
  }

private:
  void fill() {
    const std::uint32_t rows = 96;
    std::vector<double> place, velocity, counts, lists(places * rows, 0);
    near.resize(count);
    for (std::size_t i = 0; i < places; ++i) {
      const bool real_one = i < count;
      const Vector3 p = real_one ? at[i] : Vector3(1e15, 1e15, 1e15);
      place.insert(place.end(), {p.x(), p.y(), p.z(), real_one ? mass[i] : 0});
      velocity.insert(velocity.end(), {not_a_number, not_a_number, not_a_number, 1});
      for (std::size_t j = 0; real_one && j < count; ++j)
        if (j != i && between(i, j).norm() < smoothing.support) near[i].push_back(j);
    }
    for (double& value : place) value = rounded(value);
    for (std::size_t slice = 0; slice < places / 16; ++slice) {
      std::size_t longest = 0;
      for (std::size_t i = 16 * slice; i < 16 * slice + 16 && i < count; ++i)
        longest = std::max(longest, near[i].size());
      for (std::size_t r = 0; r < longest; ++r)
        for (std::size_t lane = 0; lane < 16; ++lane) {
          const std::size_t i = 16 * slice + lane;
          lists[16 * (rows * slice + r) + lane] = double(i < count && r < near[i].size() ? near[i][r] : i);
        }
      counts.push_back(double(longest));
    }
    std::vector<double> material(4 * FLUIDS * FLUID_ROWS, not_a_number);
    const auto row = [&](int at_row, std::array<double, 4> values) {
      std::copy(values.begin(), values.end(), material.begin() + 4 * (FLUID_ROWS + at_row));
    };
    row(FLUID_TRAITS, {rest, 0, 0, 0});
    row(FLUID_LIMITS, {0.25, 0.5, 1500, rounded(1e-3)});
    in = {{"rows", {double(rows)}},
          {"support", {smoothing.support}},
          {"slope_scale", {rounded(smoothing.spline_gradient())}},
          {"period_x", {period.x()}},
          {"period_y", {period.y()}},
          {"period_z", {period.z()}},
          {"fluid_place", place},
          {"near_count", counts},
          {"near", lists},
          {"fluid_material", material},
          {"fluid_velocity", velocity},
          {"value_scale", {rounded(smoothing.spline())}},
          {"relaxation", {0.5}}};
  }
};

Values only(const Values& in, std::initializer_list<const char*> names) {
  Values chosen;
  for (const char* name : names) chosen[name] = in.at(name);
  return chosen;
}

constexpr auto lambda_inputs = {
    "rows",     "support",        "value_scale", "slope_scale",    "relaxation", "period_x", "period_y",
    "period_z", "fluid_material", "fluid_place", "fluid_velocity", "near_count", "near"};

// Some 40 neighbours, each a square root, a quotient and a cube: measured 4 roundings of the sums.
constexpr double sweep_limit = 20;

/// What follows from the multiplier of place i alone, and how large its terms are.
void expect_pull(const Sweep& sweep, std::size_t i, double change, double scale, Expected& lambda,
                 Expected& pull) {
  const bool moves = i < sweep.count && sweep.mass[i] > 0;
  const Vector3 gradient =
      moves ? Vector3(sweep.rest / sweep.mass[i] * sweep.gradient(i, i)) : Vector3(0, 0, 0);
  double terms = 0;
  if (moves)
    for (std::size_t j : sweep.near[i]) terms += sweep.rest / sweep.mass[i] * sweep.gradient(j, i).norm();
  for (std::size_t a = 0; a < 3; ++a) {
    lambda.set(4 * i + a, sweep.in.at("fluid_place")[4 * i + a]);
    pull.set(4 * i + a, change * gradient[int(a)], std::abs(change) * terms + scale * gradient.norm());
  }
  lambda.set(4 * i + 3, change, scale);
  pull.set(4 * i + 3, sweep.in.at("fluid_place")[4 * i + 3]);
}

TEST_P(FluidKernels, MultipliersFollowTheConstraint) {
  for (const auto& [repeats, again] : {std::pair{false, 0.0}, {true, 0.0}, {false, 0.375}}) {
    Sweep sweep(11, repeats);
    if (repeats) sweep.put_walls();
    Values in = only(sweep.in, lambda_inputs);
    if (repeats) in.merge(only(sweep.in, {"walls", "fluid_wall"}));
    in["fluid_total"] = std::vector<double>(sweep.places, 0.0);
    in["fluid_lambda"] = in["fluid_pull"] = std::vector<double>(4 * sweep.places, sentinel);
    in["momentum"] = {again};
    std::size_t pushed = 0, left = 0;
    for (std::size_t i = 0; again > 0 && i < sweep.places; ++i)
      in["fluid_lambda"][4 * i + 3] = (double(i % 5) - 3) / 65536;
    Expected total(in["fluid_total"]), lambda(in["fluid_lambda"]), pull(in["fluid_pull"]);
    for (std::size_t i = 0; i < sweep.places; ++i) {
      double wanted = 0, scale = 0;
      const double before = in["fluid_total"][i] = i % 3 == 0 ? 0 : -std::pow(2.0, -10);
      if (i < sweep.count && sweep.mass[i] > 0) {
        double stiffness = 0.25;
        for (std::size_t k = 0; k < sweep.count; ++k)
          if (sweep.mass[k] > 0) stiffness += sweep.gradient(k, i).squaredNorm() / sweep.mass[k];
        const double error = sweep.density_error(i);
        const double last = again > 0 ? again * in["fluid_lambda"][4 * i + 3] : 0;
        const double free = last - 0.5 * std::min(error, 0.5) / (stiffness * sweep.rest);
        wanted = std::min(free, -before);
        scale = 0.5 * (1 + std::abs(error)) / (stiffness * sweep.rest) + std::abs(last);
        ++(wanted < 0 ? pushed : left);
      }
      total.set(i, before + wanted, scale + std::abs(before));
      expect_pull(sweep, i, wanted, scale, lambda, pull);
    }
    EXPECT_GT(pushed, 20u);
    EXPECT_GT(left, 20u);
    expect_kernel<kernels::fluid_lambda::Args>(
        GetParam(), std::uint32_t(sweep.places), in,
        {{"fluid_total", total}, {"fluid_lambda", lambda}, {"fluid_pull", pull}}, sweep_limit);
  }
}

// With a tensile strength what is too thin pulls, up to that: all of it inside, none at a surface or where the
// matter has parted.
TEST_P(FluidKernels, MultipliersPullUpToTheStrength) {
  const auto share = [](double x) { return std::clamp(x, 0.0, 1.0); };
  std::size_t pulling = 0, limited = 0, none = 0;
  for (const auto& [thin, strength] : {std::pair{1.5, 1.0}, {1.5, 1e-5}, {2.0, 1e-3}, {8.0, 1.0}}) {
    Sweep sweep(22);
    sweep.in["fluid_material"][4 * (FLUID_ROWS + FLUID_LIMITS) + 3] = rounded(strength);
    const std::size_t before_this = pulling + limited;
    sweep.rest = rounded(thin * sweep.rest);
    sweep.in["fluid_material"][4 * FLUID_ROWS] = sweep.rest;
    Values in = only(sweep.in, lambda_inputs);
    in["pulls"] = {1}, in["step2"] = {0.0625};
    in["fluid_total"] = std::vector<double>(sweep.places, 0.0);
    in["fluid_lambda"] = in["fluid_pull"] = std::vector<double>(4 * sweep.places, sentinel);
    Expected total(in["fluid_total"]), lambda(in["fluid_lambda"]), pull(in["fluid_pull"]);
    for (std::size_t i = 0; i < sweep.places; ++i) {
      double wanted = 0, scale = 0;
      const double before = in["fluid_total"][i] = i % 3 == 0 ? 0 : -std::pow(2.0, -16);
      if (i < sweep.count && sweep.mass[i] > 0) {
        double stiffness = 0.25, terms = 0;
        for (std::size_t k = 0; k < sweep.count; ++k)
          if (sweep.mass[k] > 0) stiffness += sweep.gradient(k, i).squaredNorm() / sweep.mass[k];
        for (std::size_t j : sweep.near[i]) terms += sweep.rest * sweep.gradient(j, i).norm();
        const double error = sweep.density_error(i), steep = sweep.rest * sweep.gradient(i, i).norm() / 1500;
        const double most = rounded(strength) * 0.0625 * sweep.mass[i];
        const double bound = most * share(4 - 4 * steep) * share(4 * error + 2);
        const double free = -0.5 * std::min(error, 0.5) / (stiffness * sweep.rest);
        wanted = std::min(free, bound - before);
        scale = 0.5 * (1 + std::abs(error)) / (stiffness * sweep.rest) + 4 * most * (1 + terms / 1500);
        ++(before + wanted <= 0 ? none : free < bound - before ? pulling : limited);
      }
      total.set(i, before + wanted, scale + std::abs(before));
      expect_pull(sweep, i, wanted, scale, lambda, pull);
    }
    EXPECT_TRUE(thin < 4 || pulling + limited == before_this) << "parted";
    expect_kernel<kernels::fluid_lambda::Args>(
        GetParam(), std::uint32_t(sweep.places), in,
        {{"fluid_total", total}, {"fluid_lambda", lambda}, {"fluid_pull", pull}}, sweep_limit);
  }
  EXPECT_GT(pulling, 20u);
  EXPECT_GT(limited, 10u);
  EXPECT_GT(none, 100u);
}

// At the start of a step the multipliers are given, and stay.
TEST_P(FluidKernels, GivenMultipliersAreTaken) {
  Sweep sweep(20, true);
  sweep.put_walls();
  Values in = only(sweep.in, lambda_inputs);
  in.merge(only(sweep.in, {"walls", "fluid_wall"}));
  in["warm"] = {1};
  in["fluid_lambda"] = in["fluid_pull"] = std::vector<double>(4 * sweep.places, sentinel);
  Expected lambda(in["fluid_lambda"]), pull(in["fluid_pull"]);
  for (std::size_t i = 0; i < sweep.places; ++i) {
    in["fluid_total"].push_back(-std::pow(2.0, -double(i % 9)));
    const bool moves = i < sweep.count && sweep.mass[i] > 0;
    expect_pull(sweep, i, moves ? in["fluid_total"][i] : 0, 0, lambda, pull);
  }
  const Expected total(in["fluid_total"]);
  expect_kernel<kernels::fluid_lambda::Args>(
      GetParam(), std::uint32_t(sweep.places), in,
      {{"fluid_total", total}, {"fluid_lambda", lambda}, {"fluid_pull", pull}}, sweep_limit);
}

TEST_P(FluidKernels, ErrorsAreMeasured) {
  const Sweep sweep(12);
  Values in = only(sweep.in, lambda_inputs);
  in["measured"] = {1};
  in["fluid_measure"] = std::vector<double>(4 * sweep.places, sentinel);
  Expected measure(in["fluid_measure"]);
  std::size_t inside = 0;
  for (std::size_t i = 0; i < sweep.places; ++i) {
    const bool real_one = i < sweep.count && sweep.mass[i] > 0;
    const double error = real_one ? sweep.density_error(i) : 0;
    const double steep2 = real_one ? (sweep.rest * sweep.gradient(i, i)).squaredNorm() : 0;
    double terms = 0; // |grad rho| is a sum of terms that cancel
    if (real_one)
      for (std::size_t j : sweep.near[i]) terms += sweep.rest * sweep.gradient(j, i).norm();
    measure.set(4 * i, error, real_one ? 1 + std::abs(error) : 0);
    measure.set(4 * i + 1, steep2, terms * (std::sqrt(steep2) + terms * 1e-6));
    measure.set(4 * i + 2, real_one && steep2 <= 1500.0 * 1500 ? 1 : 0);
    measure.set(4 * i + 3, real_one ? 1 : 0);
    inside += real_one && steep2 <= 1500.0 * 1500;
  }
  EXPECT_GT(inside, 10u);
  expect_kernel<kernels::fluid_lambda::Args>(GetParam(), std::uint32_t(sweep.places), in,
                                             {{"fluid_measure", measure}}, sweep_limit);
}

// The gradient that the sweeps use is that of C: central differences, in the test's own double.
TEST(FluidConstraint, GradientsAreThoseOfDifferences) {
  Sweep sweep(13, true);
  double worst = 0;
  for (const std::size_t i : {62u, 75u, 80u, 10u})
    for (std::size_t k = 0; k < sweep.count; k += 5)
      for (int a = 0; a < 3; ++a) {
        const double small = 1e-6 * spacing, before = sweep.at[k][a];
        sweep.at[k][a] = before + small;
        const double up = sweep.density_error(i);
        sweep.at[k][a] = before - small;
        const double down = sweep.density_error(i);
        sweep.at[k][a] = before;
        worst = std::max(worst, std::abs((up - down) / (2 * small) - sweep.gradient(k, i)[a]));
      }
  expect_below("gradient of C against central differences, of 1 / spacing", worst * spacing, 1e-7);
}

// With what a particle's own multiplier does, which fluid_lambda writes, as the test has it; far from where
// places count from, what has moved keeps the digits that places lose.
TEST_P(FluidKernels, ShiftsConserveTheCentreOfMass) {
  for (const bool repeats : {false, true}) {
    Sweep sweep(14, repeats);
    if (!repeats) // and without ghosts, whose share of the momentum goes to what holds them
      for (double& mass : sweep.mass) mass = std::abs(mass);
    Random random(15);
    Values in = only(sweep.in, {"rows", "support", "slope_scale", "period_x", "period_y", "period_z",
                                "near_count", "near"});
    in["fluid_lambda"] = in["fluid_pull"] = std::vector<double>(4 * sweep.places, 0.0);
    in["fluid_start"] = random_groups(random, sweep.places, 1);
    in["fluid_moved"] = random_groups(random, sweep.places, 1e-4);
    in["fluid_place"] = std::vector<double>(4 * sweep.places, sentinel);
    std::vector<double> change(sweep.places, 0.0);
    Vector3 rounding = Vector3::Zero(); // of what is given
    for (std::size_t i = 0; i < sweep.places; ++i) {
      const bool real_one = i < sweep.count, moves = real_one && sweep.mass[i] > 0;
      if (moves) change[i] = rounded(-1e-5 * (1 + random()));
      for (std::size_t a = 0; a < 3; ++a) {
        in["fluid_lambda"][4 * i + a] = sweep.in["fluid_place"][4 * i + a];
        if (!moves) continue;
        const double pull = sweep.rest * change[i] / sweep.mass[i] * sweep.gradient(i, i)[int(a)];
        in["fluid_pull"][4 * i + a] = rounded(pull);
        rounding[int(a)] += sweep.mass[i] * (rounded(pull) - pull);
      }
      in["fluid_lambda"][4 * i + 3] = change[i];
      in["fluid_pull"][4 * i + 3] = real_one ? sweep.mass[i] : 0;
    }
    Expected place(in["fluid_place"]), moved(in["fluid_moved"]);
    for (std::size_t i = 0; i < sweep.places; ++i) {
      const bool moves = i < sweep.count && sweep.mass[i] > 0;
      Vector3 shift = moves ? vector_at(in["fluid_pull"], i) : Vector3(0, 0, 0);
      double size = shift.norm();
      if (moves)
        for (std::size_t k = 0; k < sweep.count; ++k) {
          if (k == i || sweep.mass[k] < 0) continue;
          const Vector3 part = sweep.rest * change[k] / sweep.mass[i] * sweep.gradient(i, k);
          shift += part;
          size += part.norm();
        }
      for (std::size_t a = 0; a < 3; ++a) {
        const double u = in["fluid_moved"][4 * i + a] + shift[int(a)], from = in["fluid_start"][4 * i + a];
        moved.set(4 * i + a, u, moves ? size + 1e-4 : 0);
        place.set(4 * i + a, moves ? from + u : in["fluid_lambda"][4 * i + a], moves ? 1 : 0);
      }
      place.set(4 * i + 3, in["fluid_pull"][4 * i + 3]);
    }
    const Values out = expect_kernel<kernels::fluid_shift::Args>(
        GetParam(), std::uint32_t(sweep.places), in, {{"fluid_place", place}, {"fluid_moved", moved}},
        sweep_limit);
    if (repeats) continue;
    Vector3 sum = -rounding;
    double sizes = 0;
    for (std::size_t i = 0; i < sweep.count; ++i) {
      const Vector3 by = vector_at(out.at("fluid_moved"), i) - vector_at(in.at("fluid_moved"), i);
      sum += sweep.mass[i] * by;
      sizes += sweep.mass[i] * by.norm();
    }
    const double each = sizes / double(sweep.count);
    EXPECT_GT(each, 1e-5 * spacing);
    expect_below("sum of m dy over sum of m |dy|, in roundings of what has moved",
                 sum.norm() / sizes / (GetParam().epsilon() * (1e-4 + each) / each), 10);
  }
}

} // namespace
} // namespace pliant::test
