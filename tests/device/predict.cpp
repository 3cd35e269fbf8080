// predict on every device, against the formulas written out here in long double.
#include "kernels/predict.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace pliant::test {
namespace {

using Values = std::vector<Real4<double>>;

constexpr double sentinel = -12345;
constexpr std::size_t guard = 40; // elements behind the last particle, more than a group's tail touches

struct Problem {
  Values position, velocity, earlier_velocity, earlier_shift, external_force; // position.w: mass
  double step = 1.0 / 64, gravity[3] = {0.5, -9.8125, 0.25};                  // exact in float
  bool bdf2 = false, loaded = true;

  Problem(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    const auto fill = [&](Values& values, double size) {
      std::uniform_real_distribution<float> in(-static_cast<float>(size), static_cast<float>(size));
      for (auto& value : values) value = {in(random), in(random), in(random), in(random)};
    };
    for (Values* values : {&position, &velocity, &earlier_velocity, &earlier_shift, &external_force})
      values->resize(count);
    fill(position, 1);
    fill(velocity, 3);
    fill(earlier_velocity, 3);
    fill(earlier_shift, 0.05);
    fill(external_force, 10);
    for (std::size_t i = 0; i < count; ++i) {
      velocity[i].w = static_cast<float>(std::abs(velocity[i].w) / 3);
      position[i].w = 0.25 + 0.125 * static_cast<double>(i % 5);
    }
  }
};

struct Result {
  Values target, guess;
};

Result run(Device& device, const Problem& problem) {
  const std::size_t count = problem.velocity.size();
  const auto input = [&](const char* name, const Values& values) {
    Buffer buffer = device.allocate(name, Type::real4, count);
    device.upload(buffer, values);
    return buffer;
  };
  const auto output = [&](const char* name) {
    Buffer buffer = device.allocate(name, Type::real4, count + guard);
    device.upload(buffer, Values(count + guard, {sentinel, sentinel, sentinel, sentinel}));
    return buffer;
  };
  const Buffer position = input("position", problem.position), velocity = input("velocity", problem.velocity);
  const Buffer force = input("force", problem.external_force);
  const Buffer earlier_velocity = input("earlier_velocity", problem.earlier_velocity);
  const Buffer earlier_shift = input("earlier_shift", problem.earlier_shift);
  const Buffer target = output("target"), guess = output("guess");

  kernels::predict::Args args;
  args.threads = static_cast<std::uint32_t>(count);
  args.bdf2 = problem.bdf2;
  args.loaded = problem.loaded;
  args.time_step = problem.step;
  args.gravity_x = problem.gravity[0];
  args.gravity_y = problem.gravity[1];
  args.gravity_z = problem.gravity[2];
  args.position = position;
  args.velocity = velocity;
  if (problem.bdf2) { // Euler has neither buffer
    args.earlier_velocity = earlier_velocity;
    args.earlier_shift = earlier_shift;
  }
  if (problem.loaded) args.external_force = force;
  args.inertia_target = target;
  args.displacement = guess;
  device.run(args);
  return {device.download_real4(target), device.download_real4(guess)};
}

double component(const Real4<double>& value, int axis) {
  return axis == 0 ? value.x : axis == 1 ? value.y : value.z;
}

class Predict : public testing::TestWithParam<DeviceChoice> {
protected:
  std::unique_ptr<Device> device = GetParam().open();

  // Four operations deep with a division; 0.9 roundings of the sum of the terms were seen, 4 are allowed.
  void expect_formula(const Problem& problem, const Result& result) {
    const long double h = problem.step;
    double worst = 0;
    for (std::size_t i = 0; i < problem.velocity.size(); ++i) {
      const long double mass = problem.position[i].w;
      for (int axis = 0; axis < 3; ++axis) {
        const long double v = component(problem.velocity[i], axis), g = problem.gravity[axis];
        const long double f = problem.loaded ? component(problem.external_force[i], axis) : 0;
        long double start = 0, drift = v;
        if (problem.bdf2) {
          start = component(problem.earlier_shift[i], axis) / 3.0L;
          drift = (4 * v - component(problem.earlier_velocity[i], axis)) / 3;
        }
        const long double target = start + h * drift + h * h * (g + f / mass);
        const long double guess = target - (1 - static_cast<long double>(problem.velocity[i].w)) * h * h * g;
        const long double size = std::abs(start) + h * (std::abs(drift) + 2 * std::abs(v)) +
                                 h * h * (std::abs(g) + std::abs(f / mass));
        const double limit = 4 * GetParam().epsilon() * static_cast<double>(size);
        const double error = std::abs(static_cast<double>(component(result.target[i], axis) - target));
        worst = std::max(worst, error / limit);
        EXPECT_LE(error, limit) << "target " << i << ", axis " << axis;
        EXPECT_NEAR(component(result.guess[i], axis), static_cast<double>(guess), limit) << "guess " << i;
      }
      const double weight = static_cast<double>(mass / (h * h));
      EXPECT_NEAR(result.target[i].w, weight, 4 * GetParam().epsilon() * weight);
    }
    for (const Values* values : {&result.target, &result.guess})
      for (std::size_t i = problem.velocity.size(); i < values->size(); ++i)
        ASSERT_EQ((*values)[i].x, sentinel) << "written beyond the last particle, at " << i;
    std::printf("%s, %zu particles: worst error %.2f of the limit\n", GetParam().name.c_str(),
                problem.velocity.size(), worst);
  }
};

TEST_P(Predict, ImplicitEuler) {
  for (const std::size_t count : {1, 15, 16, 17, 127, 128, 1000}) {
    const Problem problem(count, 42);
    expect_formula(problem, run(*device, problem));
  }
}

TEST_P(Predict, WithoutLoadsNoForceBufferIsRead) {
  Problem problem(129, 47);
  problem.loaded = false;
  expect_formula(problem, run(*device, problem));
}

TEST_P(Predict, Bdf2) {
  for (const std::size_t count : {1, 17, 1000}) {
    Problem problem(count, 43);
    problem.bdf2 = true;
    expect_formula(problem, run(*device, problem));
  }
}

// A body that rests felt no gravity in the last step, one in free flight all of it.
TEST_P(Predict, RestStartsAtRestAndFlightAtItsTarget) {
  Problem problem(2, 44);
  problem.velocity = {{0, 0, 0, 0}, {1, 2, 3, 1}};
  problem.position = {{0, 0, 0, 1}, {0, 0, 0, 1}};
  problem.loaded = false;
  const Result result = run(*device, problem);
  const double fall = problem.step * problem.step * problem.gravity[1];
  EXPECT_NEAR(result.target[0].y, fall, 2e-7 * std::abs(fall));
  EXPECT_NEAR(result.guess[0].y, 0, 2e-7 * std::abs(fall));
  EXPECT_EQ(result.guess[1].y, result.target[1].y);
}

TEST_P(Predict, NotANumberStaysWhereItIs) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  Problem problem(20, 45);
  for (auto& place : problem.position) place.w = 1;
  problem.velocity[4].x = nan;
  problem.velocity[9].y = infinity;
  problem.position[17].w = nan;
  const Result result = run(*device, problem);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(std::isnan(result.target[i].x), i == 4 || i == 17) << i;
    EXPECT_EQ(std::isinf(result.target[i].y), i == 9) << i;
    EXPECT_EQ(std::isnan(result.target[i].z), i == 17) << i;
    EXPECT_EQ(std::isnan(result.guess[i].x), i == 4 || i == 17) << i;
  }
}

TEST_P(Predict, NoThreadsDoNothing) {
  const Problem problem(0, 46);
  const Result result = run(*device, problem);
  for (const auto& value : result.target) EXPECT_EQ(value.x, sentinel);
}

INSTANTIATE_TEST_SUITE_P(Devices, Predict, testing::ValuesIn(device_choices()), ChoiceName());

} // namespace
} // namespace pliant::test
