// residual_control: every decision, from a state of the solver and a residual.
#include "kernels/residual_control.h"
#include "shaders/common/solver.glsl"
#include "shaders/common/touched.glsl"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(ResidualControl);

constexpr double limit = 8; // a root of a sum of up to 1000 terms of one sign, in 256 lanes; 1.7 seen

using Changes = std::map<std::size_t, double>; ///< entry of `solver` to value

struct Case {
  std::uint32_t iteration = 16, restart = 0;
  double residual = 1;
  double momentum = 1024, moved = 0, mark = 0; ///< what momentum alone would leave, sqrt(D) |u|, contacts
  std::uint32_t second_guess = 1;
  Changes before = {}, after = {};
};

// A solve under way: best 1, first 100, tolerance 1e-3, floor 1e-2.
std::vector<double> under_way() {
  std::vector<double> solver(SOLVER_ENTRIES, 0.0);
  solver[SOLVER_START] = 5;
  solver[SOLVER_ONE_MINUS_RHO] = 0.125;
  solver[SOLVER_GAMMA] = 0.75;
  solver[SOLVER_FIRST] = 100;
  solver[SOLVER_BEST] = 1;
  solver[SOLVER_CURRENT] = 1.5;
  solver[SOLVER_ITERATIONS] = 8;
  solver[SOLVER_REASON] = 3;
  solver[SOLVER_DELAY] = 10;
  solver[SOLVER_ACCELERATE] = 1;
  return solver;
}

void expect_case(const DeviceChoice& choice, const char* name, const Case& one) {
  SCOPED_TRACE(name);
  std::vector<double> solver = under_way();
  for (const auto& [entry, value] : one.before) solver[entry] = value;
  Values in{{"iteration", {double(one.iteration)}},
            {"partial_count", {1}},
            {"restart", {double(one.restart)}},
            {"delay", {7}},
            {"accelerate", {1}},
            {"one_minus_rho", {rounded(0.03125)}},
            {"gamma", {0.875}},
            {"tolerance", {rounded(1e-3)}},
            {"floor_residual", {rounded(1e-2)}},
            {"rounding", {0.0009765625}},
            {"second_guess", {double(one.second_guess)}},
            {"residual_partial",
             {one.residual * one.residual, one.momentum * one.momentum, one.moved * one.moved, one.mark,
              sentinel, sentinel, sentinel, sentinel}},
            {"solver", solver}};
  Expected wanted(solver);
  if (one.iteration == 0 || solver[SOLVER_STOP] == 0) wanted.set(SOLVER_FLOOR, rounded(1e-2), 1e-2);
  if (one.iteration == 0) wanted.set(SOLVER_SCALE, one.momentum, one.momentum);
  for (const auto& [entry, value] : one.after)
    wanted.set(entry, value, std::abs(value) > 0 ? std::abs(value) : 0);
  expect_kernel<kernels::residual_control::Args>(choice, kernels::residual_control::group_size, in,
                                                 {{"solver", wanted}}, limit);
}

TEST_P(ResidualControl, Sums) {
  Random random(kernel_seed + 21);
  for (const std::size_t count : {1, 15, 127, 256, 257, 1000}) {
    std::vector<double> partial(4 * count), solver(SOLVER_ENTRIES, sentinel);
    for (double& value : partial) value = std::abs(random(3));
    for (std::size_t p = 0; p < count; ++p) // marks are whole numbers of units, at most 1
      partial[4 * p + 3] = TOUCHED_UNIT * std::floor(partial[4 * p + 3] / 3 / TOUCHED_UNIT);
    double sums[4] = {};
    for (std::size_t p = 0; p < partial.size(); ++p) sums[p % 4] += partial[p];
    const double e = std::sqrt(sums[0]), scale = std::sqrt(sums[1]), moved = std::sqrt(sums[2]);
    partial.resize(partial.size() + 4, sentinel);
    Expected wanted(solver);
    for (const std::size_t entry : {SOLVER_STOP, SOLVER_RESTARTS, SOLVER_ITERATIONS, SOLVER_START})
      wanted.set(entry, 0);
    wanted.set(SOLVER_ACTION, 1);
    wanted.set(SOLVER_REASON, 3);
    for (const std::size_t entry : {SOLVER_FIRST, SOLVER_BEST, SOLVER_CURRENT}) wanted.set(entry, e, e);
    wanted.set(SOLVER_ONE_MINUS_RHO, 0.0625);
    wanted.set(SOLVER_GAMMA, 0.875);
    wanted.set(SOLVER_DELAY, 9);
    wanted.set(SOLVER_ACCELERATE, 1);
    wanted.set(SOLVER_SCALE, scale, scale);
    wanted.set(SOLVER_FLOOR, 0.0009765625 * moved, 0.0009765625 * moved);
    wanted.set(SOLVER_TOUCHED, sums[3] - std::floor(sums[3]), 0);
    wanted.set(SOLVER_TRIAL, 0);
    expect_kernel<kernels::residual_control::Args>(GetParam(), kernels::residual_control::group_size,
                                                   {{"iteration", {0}},
                                                    {"partial_count", {double(count)}},
                                                    {"restart", {1}},
                                                    {"delay", {9}},
                                                    {"accelerate", {1}},
                                                    {"one_minus_rho", {0.0625}},
                                                    {"gamma", {0.875}},
                                                    {"tolerance", {rounded(1e-3)}},
                                                    {"floor_residual", {0}},
                                                    {"rounding", {0.0009765625}},
                                                    {"second_guess", {0}},
                                                    {"residual_partial", partial},
                                                    {"solver", solver}},
                                                   {{"solver", wanted}}, limit);
  }
}

TEST_P(ResidualControl, Decisions) {
  expect_case(
      GetParam(), "keeps a better iterate",
      {.residual = 0.5,
       .after = {{SOLVER_ACTION, 1}, {SOLVER_BEST, 0.5}, {SOLVER_CURRENT, 0.5}, {SOLVER_ITERATIONS, 16}}});
  expect_case(GetParam(), "lets a worse one pass", {.residual = 2.5, .after = {{SOLVER_CURRENT, 2.5}}});
  expect_case(GetParam(), "restores beyond three times the best",
              {.residual = 3.5,
               .after = {{SOLVER_ACTION, 2},
                         {SOLVER_CURRENT, 3.5},
                         {SOLVER_RESTARTS, 1},
                         {SOLVER_START, 17},
                         {SOLVER_ONE_MINUS_RHO, 0.25}}});
  expect_case(GetParam(), "shrinks gamma from the third restart on",
              {.residual = 4,
               .before = {{SOLVER_RESTARTS, 2}},
               .after = {{SOLVER_ACTION, 2},
                         {SOLVER_CURRENT, 4},
                         {SOLVER_RESTARTS, 3},
                         {SOLVER_START, 17},
                         {SOLVER_ONE_MINUS_RHO, 0.25},
                         {SOLVER_GAMMA, 0.525}}});
  expect_case(GetParam(), "keeps the spectral radius above nothing and gamma above a tenth",
              {.residual = 4,
               .before = {{SOLVER_RESTARTS, 8}, {SOLVER_ONE_MINUS_RHO, 0.75}, {SOLVER_GAMMA, 0.125}},
               .after = {{SOLVER_ACTION, 2},
                         {SOLVER_CURRENT, 4},
                         {SOLVER_RESTARTS, 9},
                         {SOLVER_START, 17},
                         {SOLVER_ONE_MINUS_RHO, 1},
                         {SOLVER_GAMMA, 0.1}}});
  expect_case(GetParam(), "restores what is not a number",
              {.residual = not_a_number,
               .after = {{SOLVER_ACTION, 2},
                         {SOLVER_CURRENT, not_a_number},
                         {SOLVER_RESTARTS, 1},
                         {SOLVER_START, 17},
                         {SOLVER_ONE_MINUS_RHO, 0.25}}});
  expect_case(GetParam(), "stops at the tolerance",
              {.residual = 0.0625,
               .after = {{SOLVER_ACTION, 1},
                         {SOLVER_BEST, 0.0625},
                         {SOLVER_CURRENT, 0.0625},
                         {SOLVER_ITERATIONS, 16},
                         {SOLVER_STOP, 1},
                         {SOLVER_REASON, 1}}});
  expect_case(GetParam(), "stops at the floor",
              {.residual = 0.0078125,
               .before = {{SOLVER_FIRST, 2}},
               .after = {{SOLVER_ACTION, 1},
                         {SOLVER_BEST, 0.0078125},
                         {SOLVER_CURRENT, 0.0078125},
                         {SOLVER_ITERATIONS, 16},
                         {SOLVER_STOP, 1},
                         {SOLVER_REASON, 2}}});
  expect_case(
      GetParam(), "does nothing after the end",
      {.residual = 0.5, .before = {{SOLVER_STOP, 1}, {SOLVER_ACTION, 1}}, .after = {{SOLVER_ACTION, 0}}});
}

TEST_P(ResidualControl, AnotherSetOfContacts) {
  expect_case(GetParam(), "a larger residual is the new best, and the new first",
              {.restart = 1,
               .residual = 512,
               .before = {{SOLVER_SCALE, 1024}},
               .after = {{SOLVER_ACTION, 1},
                         {SOLVER_BEST, 512},
                         {SOLVER_FIRST, 512},
                         {SOLVER_CURRENT, 512},
                         {SOLVER_ITERATIONS, 16},
                         {SOLVER_START, 16}}});
  expect_case(GetParam(), "but no larger than what momentum alone would leave",
              {.restart = 1,
               .residual = 512,
               .before = {{SOLVER_SCALE, 256}},
               .after = {{SOLVER_ACTION, 1},
                         {SOLVER_BEST, 512},
                         {SOLVER_FIRST, 256},
                         {SOLVER_CURRENT, 512},
                         {SOLVER_ITERATIONS, 16},
                         {SOLVER_START, 16}}});
  expect_case(GetParam(), "a smaller one leaves the first as it was",
              {.restart = 1,
               .residual = 4,
               .after = {{SOLVER_ACTION, 1},
                         {SOLVER_BEST, 4},
                         {SOLVER_CURRENT, 4},
                         {SOLVER_ITERATIONS, 16},
                         {SOLVER_START, 16}}});
  expect_case(GetParam(), "not a number is restored all the same",
              {.restart = 1,
               .residual = not_a_number,
               .after = {{SOLVER_ACTION, 2},
                         {SOLVER_CURRENT, not_a_number},
                         {SOLVER_RESTARTS, 1},
                         {SOLVER_START, 17},
                         {SOLVER_ONE_MINUS_RHO, 0.25}}});
}

// What momentum predicts may be absurd: standing still is evaluated next, and the smaller of both is the
// start.
TEST_P(ResidualControl, SecondGuess) {
  const Changes fresh{{SOLVER_RESTARTS, 0},    {SOLVER_DELAY, 7},      {SOLVER_GAMMA, 0.875},
                      {SOLVER_FIRST, 512},     {SOLVER_BEST, 512},     {SOLVER_CURRENT, 512},
                      {SOLVER_TRIAL, 1},       {SOLVER_ACTION, 3},     {SOLVER_START, 1},
                      {SOLVER_TOUCHED, 0.375}, {SOLVER_ITERATIONS, 0}, {SOLVER_ONE_MINUS_RHO, 0.03125}};
  const Case absurd{.iteration = 0, .restart = 1, .residual = 512, .momentum = 32, .moved = 4, .mark = 0.375};
  Case one = absurd;
  one.after = fresh;
  expect_case(GetParam(), "an absurd prediction: standing still is tried", one);
  Changes kept = fresh;
  kept[SOLVER_TRIAL] = kept[SOLVER_START] = 0;
  kept[SOLVER_ACTION] = 1;
  one = absurd, one.after = kept, one.second_guess = 0;
  expect_case(GetParam(), "unless there is no other guess", one);
  one = absurd, one.after = kept, one.momentum = 64;
  expect_case(GetParam(), "up to ten times what momentum leaves is no absurdity", one);
  one = absurd, one.after = kept, one.moved = 0;
  expect_case(GetParam(), "the prediction is to stand still", one);
  const Changes tried{{SOLVER_TRIAL, 1}, {SOLVER_BEST, 512}, {SOLVER_FIRST, 512}, {SOLVER_START, 1}};
  expect_case(GetParam(), "which is ten times better",
              {.iteration = 1,
               .residual = 32,
               .before = tried,
               .after = {{SOLVER_TRIAL, 0},
                         {SOLVER_ACTION, 1},
                         {SOLVER_FIRST, 32},
                         {SOLVER_BEST, 32},
                         {SOLVER_CURRENT, 32},
                         {SOLVER_ITERATIONS, 1}}});
  expect_case(GetParam(), "which is not: back to the prediction",
              {.iteration = 1,
               .residual = 64,
               .before = tried,
               .after = {{SOLVER_TRIAL, 0}, {SOLVER_ACTION, 2}, {SOLVER_CURRENT, 64}, {SOLVER_START, 2}}});
}

TEST_P(ResidualControl, ContactsThatComeAndGo) {
  expect_case(GetParam(), "another set acts: the acceleration starts anew",
              {.residual = 0.5,
               .mark = 0.375,
               .after = {{SOLVER_ACTION, 1},
                         {SOLVER_BEST, 0.5},
                         {SOLVER_CURRENT, 0.5},
                         {SOLVER_ITERATIONS, 16},
                         {SOLVER_TOUCHED, 0.375},
                         {SOLVER_START, 17}}});
  expect_case(GetParam(), "the same set",
              {.residual = 2.5,
               .mark = 0.375,
               .before = {{SOLVER_TOUCHED, 0.375}},
               .after = {{SOLVER_CURRENT, 2.5}}});
}

// A mark is the same to the last bit on every device, however many touch: one that depended on the order of
// its sum would change without a contact that does.
TEST_P(ResidualControl, MarksAreExactWhateverTheOrder) {
  for (const std::size_t count : {2, 300, 5000}) {
    std::vector<double> partial(4 * count, 0.0), solver(SOLVER_ENTRIES, 0.0);
    std::uint64_t mark = 0, mixed = 12345;
    for (std::size_t p = 0; p < count; ++p) {
      mixed = mixed * 6364136223846793005u + 1442695040888963407u;
      const std::uint64_t part = p % 2 == 0 ? 1u << 23 : mixed >> 41; // the most, and any
      partial[4 * p + 3] = TOUCHED_UNIT * static_cast<double>(part);
      mark += part;
    }
    const Values out = run_kernel<kernels::residual_control::Args>(OpenDevices::of(GetParam()),
                                                                   kernels::residual_control::group_size,
                                                                   {{"iteration", {0}},
                                                                    {"partial_count", {double(count)}},
                                                                    {"restart", {1}},
                                                                    {"delay", {0}},
                                                                    {"accelerate", {1}},
                                                                    {"one_minus_rho", {0.5}},
                                                                    {"gamma", {1}},
                                                                    {"tolerance", {0}},
                                                                    {"floor_residual", {0}},
                                                                    {"rounding", {0}},
                                                                    {"second_guess", {0}},
                                                                    {"residual_partial", partial},
                                                                    {"solver", solver}});
    EXPECT_EQ(out.at("solver")[SOLVER_TOUCHED], TOUCHED_UNIT * static_cast<double>(mark % (1u << 23)))
        << count;
  }
}

TEST_P(ResidualControl, FloorOfALongWay) {
  expect_case(GetParam(), "displacements are rounded too",
              {.residual = 0.5,
               .moved = 1024,
               .after = {{SOLVER_ACTION, 1},
                         {SOLVER_BEST, 0.5},
                         {SOLVER_CURRENT, 0.5},
                         {SOLVER_ITERATIONS, 16},
                         {SOLVER_FLOOR, 1},
                         {SOLVER_STOP, 1},
                         {SOLVER_REASON, 2}}});
}

TEST_P(ResidualControl, FirstIteration) {
  const Changes fresh{{SOLVER_RESTARTS, 0},
                      {SOLVER_DELAY, 7},
                      {SOLVER_GAMMA, 0.875},
                      {SOLVER_START, 0},
                      {SOLVER_ITERATIONS, 0}};
  Changes after = fresh;
  after.insert({{SOLVER_ACTION, 1},
                {SOLVER_FIRST, 8},
                {SOLVER_BEST, 8},
                {SOLVER_CURRENT, 8},
                {SOLVER_ONE_MINUS_RHO, 0.03125}});
  expect_case(GetParam(), "forgets the last solve",
              {.iteration = 0,
               .restart = 1,
               .residual = 8,
               .before = {{SOLVER_STOP, 1}, {SOLVER_RESTARTS, 5}},
               .after = [&] {
                 Changes c = after;
                 c[SOLVER_STOP] = 0;
                 return c;
               }()});
  after[SOLVER_FIRST] = after[SOLVER_BEST] = after[SOLVER_CURRENT] = 0.0078125;
  after[SOLVER_STOP] = 1;
  after[SOLVER_REASON] = 2;
  expect_case(GetParam(), "a scene at rest stops at once",
              {.iteration = 0, .restart = 1, .residual = 0.0078125, .after = after});
}

// The first guess is not finite: whatever finite residual follows is the best, and the solve can still end.
TEST_P(ResidualControl, FirstResidualIsNotANumber) {
  Device& device = OpenDevices::of(GetParam());
  Values in{{"iteration", {0}},
            {"partial_count", {1}},
            {"restart", {1}},
            {"delay", {7}},
            {"accelerate", {1}},
            {"one_minus_rho", {0.03125}},
            {"gamma", {0.875}},
            {"tolerance", {rounded(1e-3)}},
            {"floor_residual", {rounded(1e-6)}},
            {"rounding", {0}},
            {"second_guess", {0}},
            {"residual_partial", {not_a_number, 0, 0, 0}},
            {"solver", under_way()}};
  const auto next = [&](std::uint32_t iteration, double residual) {
    in["iteration"] = {double(iteration)};
    in["restart"] = {0};
    in["residual_partial"] = {residual * residual, 0, 0, 0};
    in["solver"] =
        run_kernel<kernels::residual_control::Args>(device, kernels::residual_control::group_size, in)
            .at("solver");
    return in["solver"];
  };
  in["solver"] =
      run_kernel<kernels::residual_control::Args>(device, kernels::residual_control::group_size, in)
          .at("solver");
  EXPECT_EQ(in["solver"][SOLVER_STOP], 0);
  EXPECT_EQ(in["solver"][SOLVER_ACTION], 2);
  EXPECT_EQ(in["solver"][SOLVER_RESTARTS], 1);
  std::vector<double> solver = next(8, 64);
  EXPECT_EQ(solver[SOLVER_ACTION], 1);
  EXPECT_EQ(solver[SOLVER_BEST], 64);
  EXPECT_EQ(solver[SOLVER_FIRST], 64)
      << "the first finite residual is what the tolerance is measured against";
  solver = next(16, 0.03125);
  EXPECT_EQ(solver[SOLVER_STOP], 1) << "2000 times less than the first finite residual";
  EXPECT_EQ(solver[SOLVER_REASON], 1);
}

} // namespace
} // namespace pliant::test
