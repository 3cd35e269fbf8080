// residual, line_control, line_apply, line_restart: every decision of the line search.
#include "kernels/line_apply.h"
#include "kernels/line_control.h"
#include "kernels/line_restart.h"
#include "kernels/residual.h"
#include "shaders/common/energy_error.glsl"
#include "shaders/common/solver.glsl"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(LineSearch);

// A division, a product, and sums over 128 lanes; a root of sums over 1000 terms of one sign.
constexpr double limit = 30;

struct ResidualProblem {
  Values in;
  std::map<std::string, Expected> wanted;
  ResidualProblem(std::size_t count, bool potential) {
    Random random(kernel_seed + 40);
    const double relief = rounded(0.6);
    std::vector<double> target = random_groups(random, count, 0.01), force = random_groups(random, count, 50);
    for (std::size_t i = 0; i < count; ++i) {
      target[4 * i + 3] = i % 7 == 5 ? -1 : rounded(100 + std::abs(target[4 * i + 3]) * 1e5);
      force[4 * i + 3] = rounded(1000 + std::abs(force[4 * i + 3]) * 100);
    }
    const std::vector<double> u = random_groups(random, count, 0.01),
                              best = random_groups(random, count, 0.01);
    std::vector<double> energy(count);
    for (double& e : energy) e = random(1);
    constexpr std::size_t group = kernels::residual::group_size;
    const std::size_t groups = (count + group - 1) / group;
    in = {{"potential", {double(potential)}},
          {"relief", {relief}},
          {"inertia_target", target},
          {"force", force},
          {"displacement", u},
          {"best_iterate", best},
          {"energy", energy},
          {"solver", std::vector<double>(SOLVER_ENTRIES, 0.0)},
          {"residual", std::vector<double>(4 * (count + behind), sentinel)},
          {"solve_partial", std::vector<double>(4 * (2 * groups + behind), sentinel)}};
    Expected r(in["residual"]), partial(in["solve_partial"]);
    for (std::size_t k = 0; k < 8 * groups; ++k) partial.set(k, 0);
    const auto add = [&](std::size_t i, int k, double value, double size) {
      partial.value[i / group * 4 + std::size_t(k)] += value;
      partial.scale[i / group * 4 + std::size_t(k)] += size;
    };
    for (std::size_t i = 0; i < count; ++i) {
      if (potential) add(i, 1, energy[i], std::abs(energy[i]));
      const double inertia = target[4 * i + 3], k = force[4 * i + 3];
      if (inertia < 0) {
        set_vector(r, i, Vector3::Zero(), Vector3::Zero());
        r.set(4 * i + 3, 0);
        continue;
      }
      const Vector3 away = vector_at(target, i) - vector_at(u, i), f = vector_at(force, i),
                    value = inertia * away + f, size = inertia * away.cwiseAbs() + f.cwiseAbs(),
                    moved = vector_at(u, i) - vector_at(best, i);
      set_vector(r, i, value, size);
      r.set(4 * i + 3, 1 / (inertia + relief * k), 1 / (inertia + relief * k));
      add(i, 0, value.squaredNorm() / (inertia + k), 2 * value.norm() * size.norm() / (inertia + k));
      add(i, 1, inertia / 2 * away.squaredNorm(), inertia * away.squaredNorm());
      add(i, 2, value.dot(moved), 2 * size.norm() * moved.norm());
      const double momentum = (inertia * vector_at(target, i)).squaredNorm() / (inertia + k),
                   way = (inertia + k) * vector_at(u, i).squaredNorm();
      add(i + groups * group, 0, momentum, momentum);
      add(i + groups * group, 1, way, way);
    }
    wanted = {{"residual", r}, {"solve_partial", partial}};
  }
};

TEST_P(LineSearch, Residual) {
  for (const std::size_t size : awkward_sizes)
    for (const bool potential : {false, true}) {
      const ResidualProblem problem(size, potential);
      expect_kernel<kernels::residual::Args>(GetParam(), static_cast<std::uint32_t>(size), problem.in,
                                             problem.wanted, limit);
    }
}

TEST_P(LineSearch, ResidualKeepsNotANumberWhereItIs) {
  ResidualProblem problem(300, true);
  Device& device = OpenDevices::of(GetParam());
  const Values clean = run_kernel<kernels::residual::Args>(device, 300, problem.in);
  problem.in["force"][4 * 150] = not_a_number;
  const Values spoiled = run_kernel<kernels::residual::Args>(device, 300, problem.in);
  expect_contained("residual", clean.at("residual"), spoiled.at("residual"), 4, {150}, 150);
  expect_contained("solve_partial", clean.at("solve_partial"), spoiled.at("solve_partial"), 4, {1}, 1);
}

TEST_P(LineSearch, ResidualWritesNothingWhereNothingWasEvaluated) {
  for (const double stop : {0.5, 1.0}) {
    ResidualProblem problem(129, true);
    problem.in["solver"][SOLVER_STOP] = stop;
    const Values out = run_kernel<kernels::residual::Args>(OpenDevices::of(GetParam()), 129, problem.in);
    EXPECT_EQ(out.at("residual"), problem.in["residual"]);
    EXPECT_EQ(out.at("solve_partial"), problem.in["solve_partial"]);
  }
}

using Changes = std::map<std::size_t, double>;

// A step of length 1 that promised a slope of 8: Phi was 64, the residual 4, at the start 100; tolerance
// 1e-3.
std::vector<double> trying() {
  std::vector<double> solver(SOLVER_ENTRIES, 0.0);
  solver[SOLVER_FIRST] = 100;
  solver[SOLVER_BEST] = 4;
  solver[SOLVER_CURRENT] = 5;
  solver[SOLVER_ITERATIONS] = 7;
  solver[SOLVER_REASON] = 3;
  solver[SOLVER_LENGTH] = 1;
  solver[SOLVER_POTENTIAL] = 64;
  solver[SOLVER_SLOPE] = 8;
  solver[SOLVER_COUNT] = 10;
  solver[SOLVER_INNER] = 3;
  solver[SOLVER_TAKEN] = 1;
  solver[SOLVER_FALL] = 100;
  solver[SOLVER_LAST_FALL] = 8;
  solver[SOLVER_RISES] = 0;
  return solver;
}

struct Case {
  bool potential = true;
  std::uint32_t iteration = 11, restart = 0;
  double residual = 3, phi = 60, steep = 1;
  double cap = 50;
  double momentum = 1024, moved = 0; ///< what momentum alone would leave, sqrt(D) |u|
  Changes before = {}, after = {};
};

// The books of Eq. 25 of a step that was tried and taken, and of the first evaluation.
void expect_fall(Expected& wanted, const std::vector<double>& solver, const Case& one) {
  if (one.iteration == 0) {
    for (const int entry :
         {SOLVER_RISES, SOLVER_FALL, SOLVER_LAST_FALL, SOLVER_LEFT, SOLVER_GAIN, SOLVER_ENERGY_ERROR})
      wanted.set(static_cast<std::size_t>(entry), entry == SOLVER_ENERGY_ERROR);
    return;
  }
  if (one.after.count(SOLVER_TAKEN) == 0 || one.restart != 0 || solver[SOLVER_RETURN] > 0 ||
      solver[SOLVER_TRIAL] > 0)
    return;
  const double change = one.phi - solver[SOLVER_POTENTIAL], low = std::max(0.0078125, one.moved / 1024),
               least = rounded(1e-5) * (one.phi + solver[SOLVER_POTENTIAL]) + 64 * low * low;
  const double slopes = (solver[SOLVER_LENGTH] * solver[SOLVER_SLOPE] + one.steep) / 2;
  const double fall = std::max(0.0, std::abs(change) > 16 * least ? -change : slopes);
  const double ratio = std::min(0.9, fall / solver[SOLVER_LAST_FALL]);
  wanted.set(SOLVER_FALL, solver[SOLVER_FALL] + fall, 128);
  wanted.set(SOLVER_LAST_FALL, fall, 16);
  wanted.set(SOLVER_LEFT, fall * ratio / (1 - ratio), 16 * 100);
}

void expect_case(const DeviceChoice& choice, const char* name, const Case& one) {
  SCOPED_TRACE(name);
  std::vector<double> solver = trying();
  for (const auto& [entry, value] : one.before) solver[entry] = value;
  Expected wanted(solver);
  wanted.set(SOLVER_TAKEN, 0);
  wanted.set(SOLVER_ACTION, 0);
  const bool evaluated = one.iteration == 0 || solver[SOLVER_STOP] == 0;
  if (evaluated) {
    wanted.set(SOLVER_CURRENT, one.residual, one.residual);
    wanted.set(SOLVER_COUNT, one.iteration == 0 ? 1 : solver[SOLVER_COUNT] + 1);
    wanted.set(SOLVER_FLOOR, 0.0078125);
    if (one.iteration == 0) wanted.set(SOLVER_SCALE, one.momentum, one.momentum);
  }
  if (one.potential) expect_fall(wanted, solver, one);
  for (const auto& [entry, value] : one.after)
    wanted.set(entry, value, std::isfinite(value) ? std::abs(value) : 0);
  // In two groups, so that sums are sums.
  const double half = one.residual * one.residual / 2;
  expect_kernel<kernels::line_control::Args>(choice, kernels::line_control::group_size,
                                             {{"potential", {double(one.potential)}},
                                              {"iteration", {double(one.iteration)}},
                                              {"partial_count", {2}},
                                              {"cap", {one.cap}},
                                              {"restart", {double(one.restart)}},
                                              {"tolerance", {rounded(1e-3)}},
                                              {"floor_residual", {0.0078125}},
                                              {"rounding", {0.0009765625}},
                                              {"noise", {rounded(1e-5)}},
                                              {"solve_partial",
                                               {half,
                                                one.phi - 8,
                                                one.steep,
                                                0,
                                                half,
                                                8,
                                                0,
                                                0,
                                                one.momentum * one.momentum,
                                                0,
                                                0,
                                                0,
                                                0,
                                                one.moved * one.moved,
                                                0,
                                                0,
                                                sentinel,
                                                sentinel,
                                                sentinel,
                                                sentinel}},
                                              {"solver", solver}},
                                             {{"solver", wanted}}, limit);
}

Changes taken(double residual, double phi) {
  return {{SOLVER_TAKEN, 1},       {SOLVER_ACTION, 1}, {SOLVER_BEST, residual}, {SOLVER_POTENTIAL, phi},
          {SOLVER_ITERATIONS, 10}, {SOLVER_INNER, 0},  {SOLVER_STOP, 0.5},      {SOLVER_LINEAR, 1}};
}
Changes with(Changes changes, const Changes& more) {
  for (const auto& [entry, value] : more) changes[entry] = value;
  return changes;
}
Changes cut(double factor, double length = 1) {
  return {{SOLVER_CUTS, 1},
          {SOLVER_RESTARTS, 1},
          {SOLVER_FACTOR, factor},
          {SOLVER_LENGTH, factor * length},
          {SOLVER_ACTION, 2}};
}

TEST_P(LineSearch, Decisions) {
  const DeviceChoice& on = GetParam();
  expect_case(on, "Phi fell", {.after = taken(3, 60)});
  expect_case(on, "Phi fell, the residual rose", {.residual = 20, .after = taken(20, 60)});
  expect_case(on, "Phi fell by too little: the root of the secant",
              {.phi = 63.99951171875, .steep = -24, .after = cut(0.25)});
  expect_case(on, "Phi rose", {.phi = 80, .steep = -8, .after = cut(0.5)});
  expect_case(on, "Phi rose much", {.phi = 80, .steep = -4000, .after = cut(0.1)});
  expect_case(on, "slope rose", {.phi = 80, .steep = 16, .after = cut(0.5)});
  expect_case(on, "a short step",
              {.phi = 80, .steep = -6, .before = {{SOLVER_LENGTH, 0.25}}, .after = cut(0.25, 0.25)});
  expect_case(on, "within noise, the slope fell",
              {.phi = 64.0001220703125, .steep = -6, .after = taken(3, 64.0001220703125)});
  expect_case(on, "within noise, neither slope nor residual fell",
              {.residual = 3.5, .phi = 64, .steep = -7, .after = cut(0.5)});
  expect_case(on, "within noise, the residual fell",
              {.residual = 2.75, .phi = 64, .steep = -7, .after = taken(2.75, 64)});
  const Changes faint{{SOLVER_SLOPE, 1. / 8192}}; // less than the noise of 5.2e-3 is promised
  expect_case(on, "a few times the noise, the slope fell",
              {.phi = 64.03125, .steep = -1. / 16384, .before = faint, .after = taken(3, 64.03125)});
  expect_case(on, "many times the noise",
              {.phi = 64.25, .steep = -1. / 16384, .before = faint, .after = cut(0.5)});
  expect_case(on, "without a potential Phi does not matter",
              {.potential = false, .phi = 640, .steep = 6, .after = taken(3, 640)});
  expect_case(on, "without a potential, the slope left is too much",
              {.potential = false, .residual = 3.5, .phi = 6, .steep = -24, .after = cut(0.25)});
  expect_case(on, "not a number is cut by half", {.residual = not_a_number, .after = cut(0.5)});
  expect_case(on, "so is an infinite potential", {.phi = anything, .after = cut(0.5)});
  expect_case(on, "tolerance",
              {.residual = 0.0625,
               .after = with(taken(0.0625, 60), {{SOLVER_STOP, 1}, {SOLVER_LINEAR, 0}, {SOLVER_REASON, 1}})});
  expect_case(
      on, "floor",
      {.residual = 0.00390625,
       .after = with(taken(0.00390625, 60), {{SOLVER_STOP, 1}, {SOLVER_LINEAR, 0}, {SOLVER_REASON, 2}})});
  expect_case(on, "nothing was evaluated", {.before = {{SOLVER_STOP, 0.5}, {SOLVER_ACTION, 1}}});
  expect_case(on, "nothing after the end", {.before = {{SOLVER_STOP, 1}, {SOLVER_ACTION, 2}}});
}

TEST_P(LineSearch, TheExactDerivativeIsTriedAgain) {
  const DeviceChoice& on = GetParam();
  expect_case(on, "a tenth of where it was indefinite",
              {.before = {{SOLVER_CONVEX, 32}}, .after = with(taken(3, 60), {{SOLVER_CONVEX, 0}})});
  expect_case(on, "not yet", {.before = {{SOLVER_CONVEX, 16}}, .after = taken(3, 60)});
}

TEST_P(LineSearch, CautionAndTheEnd) {
  const DeviceChoice& on = GetParam();
  const Changes late{{SOLVER_CUTS, 12}, {SOLVER_RESTARTS, 12}};
  expect_case(on, "after a dozen cuts, back to the best",
              {.phi = 80,
               .before = late,
               .after = {{SOLVER_CUTS, 13},
                         {SOLVER_RESTARTS, 13},
                         {SOLVER_CAUTIOUS, 1},
                         {SOLVER_RETURN, 1},
                         {SOLVER_ACTION, 3}}});
  expect_case(on, "which is taken whatever it is, with caution",
              {.phi = 80,
               .before = {{SOLVER_CUTS, 13}, {SOLVER_CAUTIOUS, 1}, {SOLVER_RETURN, 1}},
               .after = with(taken(3, 80), {{SOLVER_CUTS, 0}, {SOLVER_RETURN, 0}})});
  expect_case(on, "a step that falls ends the caution",
              {.before = {{SOLVER_CAUTIOUS, 1}, {SOLVER_CUTS, 2}},
               .after = with(taken(3, 60), {{SOLVER_CUTS, 0}, {SOLVER_CAUTIOUS, 0}})});
  expect_case(on, "no evaluation is left for a shorter step",
              {.phi = 80, .cap = 10, .after = {{SOLVER_CUTS, 1}, {SOLVER_RESTARTS, 1}, {SOLVER_STOP, 1}}});
  expect_case(on, "no descent is left",
              {.phi = 80,
               .before = with(late, {{SOLVER_CAUTIOUS, 1}}),
               .after = {{SOLVER_CUTS, 13}, {SOLVER_RESTARTS, 13}, {SOLVER_STOP, 1}, {SOLVER_REASON, 4}}});
}

TEST_P(LineSearch, FirstIterateAndAnotherProblem) {
  const DeviceChoice& on = GetParam();
  const Changes fresh = with(taken(512, 60), {{SOLVER_FIRST, 512},
                                              {SOLVER_RESTARTS, 0},
                                              {SOLVER_ITERATIONS, 0},
                                              {SOLVER_CAUTIOUS, 0},
                                              {SOLVER_CUTS, 0}});
  expect_case(on, "the first forgets the last solve",
              {.iteration = 0,
               .residual = 512,
               .before = {{SOLVER_STOP, 1},
                          {SOLVER_RESTARTS, 5},
                          {SOLVER_CAUTIOUS, 1},
                          {SOLVER_CUTS, 3},
                          {SOLVER_CONVEX, 7},
                          {SOLVER_REASON, 1}},
               .after = with(fresh, {{SOLVER_REASON, 3}, {SOLVER_CONVEX, 0}})});
  expect_case(on, "another set of contacts: a larger residual is the new first",
              {.restart = 1,
               .residual = 512,
               .phi = 800,
               .before = {{SOLVER_SCALE, 1024}},
               .after = with(taken(512, 800), {{SOLVER_FIRST, 512}})});
  expect_case(on, "but no larger than what momentum alone would leave",
              {.restart = 1,
               .residual = 512,
               .phi = 800,
               .before = {{SOLVER_SCALE, 256}},
               .after = with(taken(512, 800), {{SOLVER_FIRST, 256}})});
  expect_case(on, "a smaller one leaves the first as it was",
              {.restart = 1, .residual = 4, .phi = 800, .after = taken(4, 800)});
}

// What momentum predicts may be absurd: standing still is evaluated next, and the smaller of both is the
// start.
TEST_P(LineSearch, SecondGuess) {
  const DeviceChoice& on = GetParam();
  const Changes fresh{{SOLVER_FIRST, 512},  {SOLVER_BEST, 512}, {SOLVER_RESTARTS, 0}, {SOLVER_ITERATIONS, 0},
                      {SOLVER_CAUTIOUS, 0}, {SOLVER_TRIAL, 1},  {SOLVER_LINEAR, 0},   {SOLVER_STOP, 0},
                      {SOLVER_RETURN, 0},   {SOLVER_ACTION, 4}};
  expect_case(on, "an absurd prediction: standing still is tried",
              {.iteration = 0, .residual = 512, .momentum = 32, .moved = 2, .after = fresh});
  const Changes begun = with(taken(512, 60), {{SOLVER_FIRST, 512},
                                              {SOLVER_RESTARTS, 0},
                                              {SOLVER_ITERATIONS, 0},
                                              {SOLVER_CAUTIOUS, 0},
                                              {SOLVER_TRIAL, 0},
                                              {SOLVER_CUTS, 0}});
  expect_case(on, "up to ten times what momentum leaves is no absurdity",
              {.iteration = 0, .residual = 512, .momentum = 64, .moved = 2, .after = begun});
  expect_case(on, "the prediction is to stand still",
              {.iteration = 0, .residual = 512, .momentum = 32, .moved = 0, .after = begun});
  const Changes tried{{SOLVER_TRIAL, 1}, {SOLVER_BEST, 512}, {SOLVER_FIRST, 512}};
  expect_case(on, "which is ten times better",
              {.iteration = 1,
               .residual = 32,
               .before = tried,
               .after = with(taken(32, 60), {{SOLVER_TRIAL, 0}, {SOLVER_FIRST, 32}, {SOLVER_RETURN, 0}})});
  expect_case(on, "which is not: the prediction is evaluated again",
              {.iteration = 1,
               .residual = 64,
               .before = tried,
               .after = {{SOLVER_TRIAL, 0}, {SOLVER_RETURN, 1}, {SOLVER_ACTION, 3}}});
}

TEST_P(LineSearch, NearTheFloor) {
  const DeviceChoice& on = GetParam();
  const Changes near{{SOLVER_BEST, 0.125}, {SOLVER_FIRST, 0.25}};
  expect_case(on, "a change of Phi within what rounded positions store does not count, the residual does",
              {.residual = 0.0625,
               .phi = 64.00201416015625,
               .steep = -7,
               .before = with(near, {{SOLVER_FIRST, 16}}),
               .after = taken(0.0625, 64.00201416015625)});
  expect_case(on, "nothing lowers the residual any more: that is the floor",
              {.residual = 0.1171875,
               .phi = 64,
               .steep = 8,
               .before = near,
               .after = {{SOLVER_STOP, 1}, {SOLVER_REASON, 2}}});
  expect_case(on, "displacements are rounded too",
              {.residual = 0.5,
               .moved = 1024,
               .after = with(taken(0.5, 60),
                             {{SOLVER_FLOOR, 1}, {SOLVER_STOP, 1}, {SOLVER_LINEAR, 0}, {SOLVER_REASON, 2}})});
}

TEST_P(LineSearch, Apply) {
  for (const std::size_t count : awkward_sizes)
    for (const int action : {0, 1, 2, 3, 4}) {
      Random random(kernel_seed + 41);
      const std::vector<double> u = random_groups(random, count, 0.01),
                                best = random_groups(random, count, 0.01);
      std::vector<double> target(4 * count);
      for (std::size_t i = 0; i < count; ++i) target[4 * i + 3] = i % 5 == 3 ? -1 : 2;
      std::vector<double> solver(SOLVER_ENTRIES, not_a_number);
      solver[SOLVER_ACTION] = action;
      solver[SOLVER_FACTOR] = 0.375;
      const Values in{{"solver", solver},
                      {"displacement", guarded(u, 4)},
                      {"best_iterate", guarded(best, 4)},
                      {"inertia_target", target}};
      Expected moved(in.at("displacement")), kept(in.at("best_iterate"));
      for (std::size_t k = 0; k < 4 * count; ++k) {
        if (action == 1) kept.set(k, u[k]);
        if (action == 2) moved.set(k, best[k] + 0.375 * (u[k] - best[k]), std::abs(best[k]) + std::abs(u[k]));
        if (action == 3) moved.set(k, best[k]);
        if (action == 4 && k / 4 % 5 != 3) moved.set(k, 0);
      }
      expect_kernel<kernels::line_apply::Args>(GetParam(), static_cast<std::uint32_t>(count), in,
                                               {{"displacement", moved}, {"best_iterate", kept}}, limit);
    }
}

TEST_P(LineSearch, Restart) {
  for (const double stop : {0.0, 0.5, 1.0}) {
    std::vector<double> solver(SOLVER_ENTRIES, sentinel);
    solver[SOLVER_STOP] = stop;
    solver[SOLVER_LINEAR] = 1;
    Expected wanted(solver);
    if (stop < 1) {
      wanted.set(SOLVER_STOP, 0);
      wanted.set(SOLVER_LINEAR, 0);
    }
    expect_kernel<kernels::line_restart::Args>(GetParam(), 1, {{"solver", solver}}, {{"solver", wanted}}, 0);
  }
}

} // namespace
} // namespace pliant::test
