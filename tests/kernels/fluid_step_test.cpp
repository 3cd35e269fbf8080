// Fluids: what a step does besides the sweeps that fluid_test.cpp judges: its start, obstacles, its end and
// its row.
#include "engine/model/smoothing.h"
#include "kernels/fluid_finish.h"
#include "kernels/fluid_project.h"
#include "kernels/fluid_speed.h"
#include "kernels/fluid_sum.h"
#include "kernels/fluid_warm.h"
#include "shaders/common/contact.glsl"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FluidStep);

TEST_P(FluidStep, StartWithAShareOfTheLast) {
  Values in{{"share", {0.75}}, {"time_step", {0.25}}};
  Random random(16);
  const std::size_t size = 129;
  in["fluid_start"] = random_groups(random, size, 1);
  in["fluid_velocity"] = random_groups(random, size, 1);
  in["fluid_total"] = guarded(std::vector<double>(size, sentinel), 1);
  in["fluid_moved"] = guarded(std::vector<double>(4 * size, sentinel), 4);
  Expected total(in["fluid_total"]), moved(in["fluid_moved"]);
  for (std::size_t i = 0; i < size; ++i) {
    total.set(i, 0.75 * std::min(in["fluid_start"][4 * i + 3], 0.0), 1);
    for (std::size_t a = 0; a < 4; ++a)
      moved.set(4 * i + a, a < 3 ? 0.25 * in["fluid_velocity"][4 * i + a] : 0);
  }
  expect_kernel<kernels::fluid_warm::Args>(GetParam(), size, in,
                                           {{"fluid_total", total}, {"fluid_moved", moved}}, 1);
}

// From what has moved, not from places, of which only the sign of the mass is looked at.
TEST_P(FluidStep, VelocitiesAreWhatMovedOverTheStep) {
  Values in{{"time_step", {0.25}}};
  Random random(19);
  const std::size_t size = 129;
  in["fluid_moved"] = random_groups(random, size, 1);
  in["fluid_place"] = random_groups(random, size, 1);
  in["fluid_velocity"] = guarded(random_groups(random, size, 1), 4);
  Expected velocity(in["fluid_velocity"]);
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t a = 0; a < 3 && in["fluid_place"][4 * i + 3] > 0; ++a)
      velocity.set(4 * i + a, 4 * in["fluid_moved"][4 * i + a], 0);
  expect_kernel<kernels::fluid_speed::Args>(GetParam(), size, in, {{"fluid_velocity", velocity}}, 0);
}

TEST_P(FluidStep, RowsAreSums) {
  for (const std::size_t size : awkward_sizes) {
    Random random(17);
    Values in{{"place_count", {double(size)}},
              {"particle_count", {double(size)}},
              {"row", {1}},
              {"left_out", {5, 3}}};
    double inside = 0, error = 0, largest = -1, steep = 0, removed = 0, excess = 0, all = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const bool real_one = i % 5 != 4;
      const double row[] = {random(), rounded(1 + random()), i % 3 == 0 ? 1.0 : 0.0, real_one ? 1.0 : 0.0};
      in["fluid_measure"].insert(in["fluid_measure"].end(), row, row + 4);
      in["position"].insert(in["position"].end(),
                            {not_a_number, not_a_number, not_a_number, i % 4 == 2 ? 0.0 : 2.0});
      removed += i % 4 == 2;
      if (!real_one) continue;
      inside += row[2], error += row[2] * std::abs(row[0]), steep += row[1];
      largest = std::max(largest, row[0]);
      excess += std::max(row[0], 0.0), all += 1;
    }
    in["fluid_row"] = std::vector<double>(24, sentinel);
    Expected row(in["fluid_row"]);
    const double wanted[] = {inside, error, largest, steep, removed, 5, 3, all > 0 ? excess / all : 0};
    for (std::size_t k = 0; k < 8; ++k) row.set(8 + k, wanted[k], k == 1 || k == 3 || k == 7 ? wanted[k] : 0);
    expect_kernel<kernels::fluid_sum::Args>(GetParam(), kernels::fluid_sum::group_size, in,
                                            {{"fluid_row", row}}, 16);
  }
}

// The share of the spline beyond a plane, by adding up rings of planes.
double beyond(const Smoothing& smoothing, double distance) {
  const int parts = 400;
  double sum = 0;
  for (int i = 0; i < parts; ++i) { // planes, by the middle of each piece
    const double z = distance + (smoothing.support - distance) * (i + 0.5) / parts;
    for (int k = 0; k < parts; ++k) {
      const double r = smoothing.support * (k + 0.5) / parts;
      sum += smoothing.spline_value(std::hypot(r, z)) * 2 * 3.14159265358979 * r * smoothing.support / parts *
             (smoothing.support - distance) / parts;
    }
  }
  return sum;
}

// Out of a floor and a ball to the distance asked, along the shortest way; friction takes back what slid; and
// walls count in the density as if they were full.
TEST_P(FluidStep, ObstaclesPushOut) {
  const double radius = 0.0625, friction = 0.5, share = 0.75;
  const Smoothing smoothing{0.25, 3};
  std::vector<double> table(4 * OBSTACLES * OBSTACLE_ROWS, 0.0);
  const auto row = [&](int obstacle, int at, std::array<double, 4> values) {
    std::copy(values.begin(), values.end(), table.begin() + 4 * (OBSTACLE_ROWS * obstacle + at));
  };
  for (int o = 0; o < 2; ++o)
    for (int a = 0; a < 3; ++a)
      row(o, OBSTACLE_AXES + a, {a == 0 ? 1.0 : 0, a == 1 ? 1.0 : 0, a == 2 ? 1.0 : 0, 0});
  row(0, OBSTACLE_KIND, {OBSTACLE_PLANE, friction, 0, 0});
  row(0, OBSTACLE_CENTRE, {0, 0, 0, rounded(1e18)});
  row(1, OBSTACLE_KIND, {OBSTACLE_SPHERE, 0, 1, 0});
  row(1, OBSTACLE_CENTRE, {0, 2, 0, 1});
  row(1, OBSTACLE_SIZE, {0.5, 0, 0, 0});
  Values in{{"obstacles", {2}},
            {"radius", {radius}},
            {"support", {smoothing.support}},
            {"share", {share}},
            {"obstacle", table}};
  const std::vector<std::array<double, 8>> cases = {
      // y*                      start            (w: mass)
      {0.25, 0.5, 0, 1, 0, 0, 0, 0},     // free
      {0.25, -0.1875, 0, 1, 0, 0, 0, 0}, // in the floor: 0.25 deep, slid 0.25, of which friction takes 0.125
      {0.0625, -0.4375, 0, 1, 0, 0, 0, 0}, // slid less than friction holds
      {0.25, 2, 0, 1, 0.25, 2, 0.125, 0},  // in the ball, which does not slip
      {0.25, -1, 0, -1, 0, 0, 0, 0},       // a ghost stays
      {0.25, -1, 0, 0, 0, 0, 0, 0},        // nothing
      {0.25, 0.15625, 0, 1, 0, 0, 0, 0}};  // above the floor, within the spline's reach
  for (const auto& one : cases) {
    in["fluid_place"].insert(in["fluid_place"].end(), one.begin(), one.begin() + 4);
    in["fluid_start"].insert(in["fluid_start"].end(), one.begin() + 4, one.end());
  }
  Expected place(in["fluid_place"]);
  const std::vector<std::array<double, 3>> wanted = {{0.25, 0.5, 0},     {0.125, 0.0625, 0}, {0, 0.0625, 0},
                                                     {0.5625, 2, 0.125}, {0.25, -1, 0},      {0.25, -1, 0},
                                                     {0.25, 0.15625, 0}};
  for (std::size_t i = 0; i < wanted.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) place.set(4 * i + a, wanted[i][a], 1);
  // What was pushed is added to what has moved, in places that have moved on without it too.
  in["fluid_moved"] = std::vector<double>(4 * cases.size(), 0.0);
  Expected moved(in["fluid_moved"]);
  for (std::size_t i = 0; i < wanted.size(); ++i)
    for (std::size_t a = 0; a < 3 && cases[i][3] > 0; ++a) {
      in["fluid_moved"][4 * i + a] = cases[i][a] - cases[i][4 + a];
      moved.set(4 * i + a, wanted[i][a] - cases[i][4 + a], 1);
    }
  in["fluid_wall"] = std::vector<double>(4 * cases.size(), sentinel);
  Expected wall(in["fluid_wall"]);
  // Free and near nothing; at the radius from the floor; 0.15625 above it; at the radius from the ball.
  const double distances[] = {1, radius, radius, radius, 1, 1, 0.15625};
  const Values out =
      run_kernel<kernels::fluid_project::Args>(OpenDevices::of(GetParam()), std::uint32_t(cases.size()), in);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const double d = distances[i], small = 1e-4;
    const bool near = d < smoothing.support;
    const double here = near ? share * beyond(smoothing, d) : 0;
    const double slope =
        near ? share * (beyond(smoothing, d + small) - beyond(smoothing, d - small)) / (2 * small) : 0;
    const double values[] = {i == 3 ? slope : 0, i == 3 ? 0 : slope, 0, here};
    // The sums above are right within 1e-5 of the whole.
    for (std::size_t k = 0; k < 4; ++k) wall.set(4 * i + k, values[k], anything);
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(out.at("fluid_wall")[4 * i + k], values[k], k == 3 ? 2e-4 : 2e-3 / smoothing.support)
          << i << " " << k;
  }
  for (const double spread : {0.0, 1.0}) {
    in["spread"] = {spread};
    if (spread > 0) in["fluid_moved"].assign(4 * cases.size(), 0.0);
    expect_kernel<kernels::fluid_project::Args>(
        GetParam(), std::uint32_t(cases.size()), in,
        {{"fluid_place", place}, {"fluid_wall", wall}, {"fluid_moved", moved}}, 8);
  }
}

// Far from a floor places are where the step began and what has moved since, one by one and many at once.
TEST_P(FluidStep, FarFromObstaclesNothingIsPushed) {
  const std::size_t size = 129;
  Random random(21);
  Values in{{"obstacles", {1}}, {"radius", {0.0625}}, {"support", {0.25}}, {"share", {0.75}}};
  in["obstacle"] = std::vector<double>(4 * OBSTACLES * OBSTACLE_ROWS, 0.0);
  for (int a = 0; a < 3; ++a) in["obstacle"][4 * (OBSTACLE_AXES + std::size_t(a)) + std::size_t(a)] = 1;
  in["obstacle"][4 * OBSTACLE_KIND] = OBSTACLE_PLANE;
  in["obstacle"][4 * OBSTACLE_CENTRE + 3] = rounded(1e18);
  in["fluid_start"] = random_groups(random, size, 1);
  in["fluid_moved"] = random_groups(random, size, 0.25);
  in["fluid_place"] = in["fluid_wall"] = std::vector<double>(4 * size, sentinel);
  for (std::size_t i = 0; i < size; ++i) {
    in["fluid_start"][4 * i + 1] = rounded(2 + in["fluid_start"][4 * i + 1]);
    in["fluid_place"][4 * i + 3] = i % 5 == 1 ? -1 : 1;
  }
  // One in the middle is at the floor: its neighbours, which the processor takes with it, are not.
  in["fluid_start"][4 * 64 + 1] = 0.0625;
  in["fluid_moved"][4 * 64 + 1] = 0;
  Expected place(in["fluid_place"]), wall(in["fluid_wall"]);
  const Expected moved(in["fluid_moved"]);
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t a = 0; a < 4; ++a) {
      if (i % 5 != 1 && a < 3)
        place.set(4 * i + a, in["fluid_start"][4 * i + a] + in["fluid_moved"][4 * i + a], 4);
      wall.set(4 * i + a, 0, i == 64 ? anything : 0);
    }
  expect_kernel<kernels::fluid_project::Args>(
      GetParam(), size, in, {{"fluid_place", place}, {"fluid_wall", wall}, {"fluid_moved", moved}}, 1);
}

// Beyond a side that repeats a particle comes in on the other; beyond another it is removed, and stays so. Of
// a pull nothing is kept for the next step; what a nozzle holds comes a step nearer to its end; ghosts stay
// out.
TEST_P(FluidStep, DomainsRepeatOrEnd) {
  Values in{{"bounded", {1}},
            {"particle_count", {8}},
            {"time_step", {0.25}},
            {"base_x", {1}},
            {"base_y", {0}},
            {"base_z", {0}},
            {"low_x", {0}},
            {"low_y", {0}},
            {"low_z", {-1}},
            {"high_x", {2}},
            {"high_y", {2}},
            {"high_z", {1}},
            {"period_x", {2}},
            {"period_y", {0}},
            {"period_z", {2}},
            {"fluid_kind", {0, 1, 0, 1, 0, 0, 0, 0}},
            {"origin", {1, 0, 0, 0, 0.5, 0, 0, 0}},
            {"fluid_particle", {4, 2, 0, 1, 3, 5, 6, 7, 8}}};
  in["fluid_place"] = {0.5, 1, 0,      2,   /**/ 2.25, 1, -1.5,   2, /**/ -0.25, 1,
                       0,   2, /**/ 1, 2.5, 0,         2, /**/ 1, 1, 0,          0};
  const std::vector<double> more{0.75,     1,   0,   -2, /**/ 0.5, 1, 0.5, -2,
                                 /**/ 0.5, 0.5, 0.5, 2,  /**/ 1,   1, 1,   -1};
  in["fluid_place"].insert(in["fluid_place"].end(), more.begin(), more.end());
  in["fluid_velocity"] = std::vector<double>(36, 0.5);
  in["fluid_total"] = {-1, -2, -3, -4, -5, 0, 0, 1, 0};
  in["position"] = in["velocity"] = std::vector<double>(32, sentinel);
  in["velocity"][4 * 5 + 3] = 0.625; // s
  in["velocity"][4 * 6 + 3] = 0.125;
  Expected position(in["position"]), velocity(in["velocity"]);
  const auto set = [](Expected& to, std::size_t i, std::array<double, 4> values) {
    for (std::size_t k = 0; k < 4; ++k) to.set(4 * i + k, values[k], 1);
  };
  // Body 0 is at 1 and places count from 1; body 1 is at 0.5.
  set(position, 4, {0.5, 1, 0, 2});
  set(position, 2, {0.25, 1, 0.5, 2});
  set(position, 0, {1.75, 1, 0, 2});
  set(position, 1, {1.5, 2.5, 0, 0});
  set(velocity, 4, {0.5, 0.5, 0.5, -16});
  set(velocity, 2, {0.5, 0.5, 0.5, -32});
  set(velocity, 0, {0.5, 0.5, 0.5, -48});
  set(velocity, 1, {0, 0, 0, 0});
  set(position, 5, {0.75, 1, 0, 2});
  set(position, 6, {0.5, 1, 0.5, 2});
  set(position, 7, {0.5, 0.5, 0.5, 2});
  set(velocity, 5, {0.5, 0.5, 0.5, 0.375});
  set(velocity, 6, {0.5, 0.5, 0.5, 0});
  set(velocity, 7, {0.5, 0.5, 0.5, 0});
  expect_kernel<kernels::fluid_finish::Args>(GetParam(), 9, in,
                                             {{"position", position}, {"velocity", velocity}}, 4);
}

} // namespace
} // namespace pliant::test
