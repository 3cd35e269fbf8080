// conjugate_control, conjugate_direction, conjugate_update: the recurrence and its ends.
#include "kernels/conjugate_control.h"
#include "kernels/conjugate_direction.h"
#include "kernels/conjugate_update.h"
#include "shaders/common/energy_error.glsl"
#include "shaders/common/solver.glsl"
#include "shaders/common/trust_region.glsl"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(Conjugate);

constexpr double limit = 8; // a product and a sum; a root and a division
using Changes = std::map<std::size_t, double>;

// The third iteration: the last r . z was 16, they end at 1; the residual is 4 of the first 400.
std::vector<double> under_way() {
  std::vector<double> solver(SOLVER_ENTRIES, 0.0);
  solver[SOLVER_LINEAR] = 1;
  solver[SOLVER_STOP] = 0.5;
  solver[SOLVER_FIRST] = 400;
  solver[SOLVER_BEST] = 4;
  solver[SOLVER_COUNT] = 10;
  solver[SOLVER_INNER] = 2;
  solver[SOLVER_RZ] = 16;
  solver[SOLVER_RZ_ENOUGH] = 1;
  solver[SOLVER_SLOPE] = 5;
  solver[SOLVER_LENGTH] = 0.25;
  solver[SOLVER_CG_STEP] = 7;
  solver[SOLVER_CG_KEEP] = 9;
  return solver;
}

void expect_case(const DeviceChoice& choice, const char* name, bool after, double found,
                 const Changes& before, const Changes& changes, double cap = 50, double energy_tolerance = 0,
                 bool potential = true) {
  SCOPED_TRACE(name);
  std::vector<double> solver = under_way();
  for (const auto& [entry, value] : before) solver[entry] = value;
  Expected wanted(solver);
  wanted.set(SOLVER_ACTION, 0);
  if (after && solver[SOLVER_LINEAR] > 0) wanted.set(SOLVER_COUNT, 11);
  for (const auto& [entry, value] : changes) wanted.set(entry, value, std::abs(value));
  expect_kernel<kernels::conjugate_control::Args>(
      choice, kernels::conjugate_control::group_size,
      {{"after", {double(after)}},
       {"partial_count", {2}},
       {"potential", {double(potential)}},
       {"cap", {cap}},
       {"energy_tolerance", {energy_tolerance}},
       {"solve_partial", {found - 1, 5, 5, 5, 1, 5, 5, 5, sentinel, 0, 0, 0}},
       {"solver", solver}},
      {{"solver", wanted}}, limit);
}

Changes with(Changes changes, const Changes& more) {
  for (const auto& [entry, value] : more) changes[entry] = value;
  return changes;
}
const Changes complete{
    {SOLVER_ACTION, 2}, {SOLVER_LINEAR, 0}, {SOLVER_STOP, 0}, {SOLVER_LENGTH, 1}, {SOLVER_EDGE, 1}};
const Changes on_and_on{{SOLVER_ACTION, 1}, {SOLVER_CG_KEEP, 0.25}, {SOLVER_RZ, 4}, {SOLVER_DIRECTION2, 4}};
const Changes one_step{
    {SOLVER_ACTION, 1}, {SOLVER_CG_STEP, 0.5}, {SOLVER_SLOPE, 13}, {SOLVER_PROMISE, 4}, {SOLVER_INNER, 3}};

TEST_P(Conjugate, BeforeTheProduct) {
  const DeviceChoice& on = GetParam();
  expect_case(on, "goes on", false, 4, {}, on_and_on);
  expect_case(on, "enough", false, 0.5, {}, complete);
  expect_case(on, "no iteration is left", false, 4, {}, complete, 10);
  expect_case(on, "not a number ends them", false, not_a_number, {}, complete);
  const Changes first{{SOLVER_INNER, 0}};
  const Changes begun{
      {SOLVER_ACTION, 1}, {SOLVER_CG_KEEP, 0}, {SOLVER_RZ, 8}, {SOLVER_SLOPE, 0}, {SOLVER_DIRECTION2, 8}};
  expect_case(on, "first, .1 of the residual", false, 8, first, with(begun, {{SOLVER_RZ_ENOUGH, 8 * 0.01}}));
  expect_case(on, "first, tighter near the end", false, 8, {{SOLVER_INNER, 0}, {SOLVER_BEST, 0.015625}},
              with(begun, {{SOLVER_RZ_ENOUGH, 8 * 0.015625 / 400}}));
  const Changes over{{SOLVER_LINEAR, 0}, {SOLVER_STOP, 1}, {SOLVER_REASON, 4}};
  for (const double nothing : {0.0, -1.0, not_a_number, anything})
    expect_case(on, "nothing to descend", false, nothing, first, over);
  expect_case(on, "first, and no product is left", false, 8, first,
              {{SOLVER_LINEAR, 0}, {SOLVER_STOP, 1}, {SOLVER_REASON, 3}}, 10);
  expect_case(on, "no direction is wanted", false, 4, {{SOLVER_LINEAR, 0}, {SOLVER_ACTION, 1}}, {});
}

TEST_P(Conjugate, AfterTheProduct) {
  const DeviceChoice& on = GetParam();
  expect_case(on, "a step", true, 32, {}, one_step);
  expect_case(on, "the last one", true, 32, {}, with(one_step, complete), 11);
  expect_case(on, "one alone, where caution is due", true, 32, {{SOLVER_CAUTIOUS, 1}},
              with(one_step, complete));
  for (const double found : {0.0, -3.0, not_a_number, anything}) {
    expect_case(on, "no positive curvature: what there is", true, found, {},
                with(complete, {{SOLVER_CG_STEP, 0}, {SOLVER_CONVEX, 4}}));
    expect_case(
        on, "none at first: the preconditioned gradient", true, found, {{SOLVER_INNER, 0}, {SOLVER_SLOPE, 0}},
        with(complete, {{SOLVER_CG_STEP, 1}, {SOLVER_SLOPE, 16}, {SOLVER_PROMISE, 16}, {SOLVER_CONVEX, 4}}));
  }
  expect_case(on, "no direction is wanted", true, 32, {{SOLVER_LINEAR, 0}, {SOLVER_ACTION, 2}}, {});
}

// The potential fell by 8 so far; the direction found so far, of slope 5, will add some 2.5.
TEST_P(Conjugate, EnergyTolerance) {
  const DeviceChoice& on = GetParam();
  constexpr double tolerance = 0.0625;
  const Changes first{{SOLVER_INNER, 0}, {SOLVER_FALL, 8}, {SOLVER_GAIN, 0.5}};
  const Changes begun{{SOLVER_ACTION, 1}, {SOLVER_CG_KEEP, 0}, {SOLVER_SLOPE, 0}, {SOLVER_DIRECTION2, 2}};
  expect_case(on, "first, too much is left", false, 2, first,
              with(begun, {{SOLVER_RZ, 2},
                           {SOLVER_RZ_FIRST, 2},
                           {SOLVER_RZ_ENOUGH, 2 * 0.01},
                           {SOLVER_ENERGY_ERROR, 1. / 9}}),
              50, tolerance);
  expect_case(on, "first, little enough: the solve ends", false, 1, first,
              {{SOLVER_LINEAR, 0}, {SOLVER_STOP, 1}, {SOLVER_REASON, 1}, {SOLVER_ENERGY_ERROR, 0.5 / 8.5}},
              50, tolerance);
  expect_case(on, "first, nothing is known of what r . z is worth", false, 2, with(first, {{SOLVER_GAIN, 0}}),
              with(begun, {{SOLVER_RZ, 2}, {SOLVER_RZ_FIRST, 2}, {SOLVER_RZ_ENOUGH, 2 * 0.01}}), 50,
              tolerance);
  const Changes later{{SOLVER_FALL, 8}, {SOLVER_GAIN, 0.25}};
  expect_case(on, "goes on", false, 4, later, on_and_on, 50, tolerance);
  expect_case(on, "what is left is a quarter as much", false, 1.25, later, complete, 50, tolerance);
  expect_case(on, "a long step", true, 32, with(later, {{SOLVER_RZ_FIRST, 64}}),
              with(one_step, {{SOLVER_GAIN, 0.5}}), 50, tolerance);
  expect_case(on, "all steps together", true, 32, with(later, {{SOLVER_RZ_FIRST, 16}}),
              with(one_step, {{SOLVER_GAIN, 13. / 16}}), 50, tolerance);
}

// The last step had a length of 4 and was to lower the potential by 8.
TEST_P(Conjugate, RadiusAfterAStep) {
  const DeviceChoice& on = GetParam();
  const Changes first{{SOLVER_INNER, 0}, {SOLVER_STEP2, 16}, {SOLVER_PROMISE, 8},
                      {SOLVER_EDGE, 1},  {SOLVER_LENGTH, 1}, {SOLVER_STEP_ALONG, 3}};
  const Changes begun{{SOLVER_ACTION, 1}, {SOLVER_CG_KEEP, 0},    {SOLVER_RZ, 8},
                      {SOLVER_SLOPE, 0},  {SOLVER_DIRECTION2, 8}, {SOLVER_RZ_ENOUGH, 8 * 0.01},
                      {SOLVER_STEP2, 0},  {SOLVER_STEP_ALONG, 0}, {SOLVER_PROMISE, 0},
                      {SOLVER_EDGE, 0}};
  const auto after = [&](const char* name, const Changes& step, double radius, bool potential = true) {
    expect_case(on, name, false, 8, with(first, step), with(begun, {{SOLVER_RADIUS, radius}}), 50, 0,
                potential);
  };
  after("cut", {{SOLVER_LENGTH, 0.25}, {SOLVER_LAST_FALL, 7}}, 1);
  after("a whole step that is good: any length goes on", {{SOLVER_LAST_FALL, 7}}, 0);
  after("a whole step that is bad", {{SOLVER_LAST_FALL, 1.5}}, 2);
  const Changes edge{{SOLVER_EDGE, 2}, {SOLVER_RADIUS, 4}};
  after("good, at the edge", with(edge, {{SOLVER_LAST_FALL, 7}}), 8);
  after("fair, at the edge", with(edge, {{SOLVER_LAST_FALL, 3}}), 4);
  after("bad, at the edge", with(edge, {{SOLVER_LAST_FALL, 1}}), 2);
  after("good, inside", {{SOLVER_RADIUS, 5}, {SOLVER_LAST_FALL, 7}}, 5);
  after("where there is no potential the line search alone judges", with(edge, {}), 8, false);
  after("where caution is due", with(edge, {{SOLVER_CAUTIOUS, 1}}), 0);
  expect_case(on, "given up before it was complete", false, 8,
              with(first, {{SOLVER_EDGE, 0}, {SOLVER_LENGTH, 0.25}, {SOLVER_RADIUS, 5}}), begun);
}

// |d|^2 = 9, d P p = 1, |p|^2 = 3: d + 2 p has a length of 5.
TEST_P(Conjugate, StepsEndAtTheEdge) {
  const DeviceChoice& on = GetParam();
  const Changes region{{SOLVER_RADIUS, 5}, {SOLVER_STEP2, 9}, {SOLVER_STEP_ALONG, 1}, {SOLVER_DIRECTION2, 3}};
  expect_case(on, "inside", true, 32, region, with(one_step, {{SOLVER_STEP2, 9 + 0.5 * (2 + 0.5 * 3)}}));
  const auto edge = [](double found) {
    return with(complete, {{SOLVER_CG_STEP, 2},
                           {SOLVER_SLOPE, 5 + 2 * 16},
                           {SOLVER_PROMISE, 2 * (16 - found)},
                           {SOLVER_STEP2, 25},
                           {SOLVER_INNER, 3},
                           {SOLVER_EDGE, 2}});
  };
  for (const double found : {4.0, 0.0, -3.0})
    expect_case(on, "at the edge, whatever the curvature", true, found, region, edge(found));
  expect_case(on, "no number has no edge", true, not_a_number, region,
              with(complete, {{SOLVER_CG_STEP, 0}, {SOLVER_CONVEX, 4}}));
  expect_case(on, "the energy's estimate sees the whole step", true, 4,
              with(region, {{SOLVER_RZ_FIRST, 32}, {SOLVER_FALL, 8}}), with(edge(4), {{SOLVER_GAIN, 4}}), 50,
              0.0625);
  expect_case(on, "the next direction", false, 4, with(region, {{SOLVER_CG_STEP, 2}}),
              with(on_and_on, {{SOLVER_STEP_ALONG, 0.25 * (1 + 2 * 3)}, {SOLVER_DIRECTION2, 4 + 3. / 16}}));
}

TEST_P(Conjugate, DirectionAndUpdate) {
  for (const std::size_t count : awkward_sizes)
    for (const int action : {0, 1, 2})
      for (const int inner : {0, 2}) {
        Random random(kernel_seed + 42);
        const std::vector<double> z = random_groups(random, count, 0.01),
                                  best = random_groups(random, count, 0.01),
                                  p = random_groups(random, count, 0.01),
                                  d = random_groups(random, count, 0.01), q = random_groups(random, count, 9),
                                  r = random_groups(random, count, 9), u = random_groups(random, count, 0.01);
        std::vector<double> solver(SOLVER_ENTRIES, not_a_number);
        solver[SOLVER_ACTION] = action;
        solver[SOLVER_INNER] = inner;
        solver[SOLVER_CG_KEEP] = 0.375;
        solver[SOLVER_CG_STEP] = 0.625;
        const auto threads = static_cast<std::uint32_t>(count);
        Values in{{"solver", solver},           {"preconditioned", z},      {"best_iterate", best},
                  {"direction", guarded(p, 4)}, {"descent", guarded(d, 4)}, {"displacement", guarded(u, 4)}};
        Expected direction(in["direction"]), descent(in["descent"]), moved(in["displacement"]);
        for (std::size_t k = 0; k < 4 * count; ++k) {
          if (action == 2) moved.set(k, best[k] + d[k], std::abs(best[k]) + std::abs(d[k]));
          if (action != 1) continue;
          if (inner > 0) {
            direction.set(k, z[k] + 0.375 * p[k], std::abs(z[k]) + std::abs(p[k]));
          } else {
            direction.set(k, z[k]);
            descent.set(k, 0);
          }
        }
        expect_kernel<kernels::conjugate_direction::Args>(
            GetParam(), threads, in,
            {{"direction", direction}, {"descent", descent}, {"displacement", moved}}, limit);
        in = {{"solver", solver},
              {"direction", p},
              {"force", q},
              {"best_iterate", best},
              {"descent", guarded(d, 4)},
              {"residual", guarded(r, 4)},
              {"displacement", guarded(u, 4)}};
        Expected grown(in["descent"]), left(in["residual"]), end(in["displacement"]);
        for (std::size_t k = 0; k < 4 * count; ++k) {
          if (action == 0) continue;
          const double sum = d[k] + 0.625 * p[k], size = std::abs(d[k]) + std::abs(p[k]);
          grown.set(k, sum, size);
          if (action == 2) end.set(k, best[k] + sum, std::abs(best[k]) + size);
          if (action == 1 && k % 4 < 3) left.set(k, r[k] - 0.625 * q[k], std::abs(r[k]) + std::abs(q[k]));
        }
        expect_kernel<kernels::conjugate_update::Args>(
            GetParam(), threads, in, {{"descent", grown}, {"residual", left}, {"displacement", end}}, limit);
      }
}

} // namespace
} // namespace pliant::test
