// history_*: L-BFGS by products alone, against the two loops written out (Nocedal 1980), over more steps than
// it remembers and through a step that is not remembered.
#include "kernels/history_control.h"
#include "kernels/history_direction.h"
#include "kernels/history_dots.h"
#include "kernels/history_store.h"
#include "shaders/common/energy_error.glsl"
#include "shaders/common/solver.glsl"
#include "tests/support/kernel_particles.h"

#include <deque>

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(History);

using Groups = std::vector<Real4<double>>;
using Vector = Eigen::VectorXd;

Groups groups_of(const Vector& v, double w = 0) {
  Groups groups(static_cast<std::size_t>(v.size() / 3));
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    groups[i] = {v[at], v[at + 1], v[at + 2], w};
  }
  return groups;
}

Vector vector_of(const Groups& groups) {
  Vector v(static_cast<Eigen::Index>(3 * groups.size()));
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    v.segment<3>(at) << groups[i].x, groups[i].y, groups[i].z;
  }
  return v;
}

struct Pair {
  Vector step, change;
};

Vector two_loops(const std::deque<Pair>& pairs, const Vector& r, const Vector& inverse) {
  Vector q = r;
  std::vector<double> alpha(pairs.size());
  for (std::size_t k = pairs.size(); k-- > 0;) {
    alpha[k] = pairs[k].step.dot(q) / pairs[k].step.dot(pairs[k].change);
    q -= alpha[k] * pairs[k].change;
  }
  const Pair& newest = pairs.back();
  const double gamma =
      newest.step.dot(newest.change) / newest.change.dot(inverse.cwiseProduct(newest.change));
  Vector d = gamma * inverse.cwiseProduct(q);
  for (std::size_t k = 0; k < pairs.size(); ++k)
    d += (alpha[k] - pairs[k].change.dot(d) / pairs[k].step.dot(pairs[k].change)) * pairs[k].step;
  return d;
}

TEST_P(History, IsTwoLoops) {
  constexpr std::uint32_t n = 300;
  constexpr std::size_t partials = (n + 127) / 128;
  const std::unique_ptr<Device> device = GetParam().open();
  const auto real4 = [&](const char* name, std::size_t count) {
    return device->allocate(name, Type::real4, count);
  };
  const Buffer displacement = real4("displacement", n), best = real4("best", n),
               residual = real4("residual", n), image = real4("image", n),
               history = real4("history", std::size_t{HISTORY_ROWS} * n), sums = real4("sums", partials),
               solver = device->allocate("solver", Type::real, SOLVER_ENTRIES),
               dots = device->allocate("dots", Type::real, HISTORY_DOTS * partials),
               gram = device->allocate("gram", Type::real, 2 * MEMORY * MEMORY);
  Random random(kernel_seed + 60);
  const auto draw = [&](double low, double high) {
    Vector v(3 * n);
    for (double& value : v) value = low + (high - low) * (random(1) + 1) / 2;
    return v;
  };
  const Vector stiffness = draw(1, 3), inverse = draw(0.3, 0.9), solution = draw(-1, 1);
  Vector u = draw(-1, 1), u_best = u, r_best;
  std::deque<Pair> pairs;
  for (unsigned k = 0; k < 9; ++k) {
    Vector r = stiffness.cwiseProduct(solution - u);
    if (k == 4) r = r_best + 0.5 * (u - u_best); // grows along the step: not remembered
    if (k > 0) {
      const Pair pair{u - u_best, r_best - r};
      if (pair.step.dot(pair.change) > 0)
        pairs.push_back(pair);
      else if (pairs.size() == MEMORY)
        pairs.pop_front();
      if (pairs.size() > MEMORY) pairs.pop_front();
    }
    const Vector z = inverse.cwiseProduct(r);
    device->upload(displacement, groups_of(u));
    device->upload(best, groups_of(u_best));
    device->upload(residual, groups_of(r, 0.5));
    device->upload(image, groups_of(z));
    Groups sum(partials, Real4<double>{0, 7, 7, 7});
    sum[1].x = r.dot(z);
    device->upload(sums, sum);
    for (const int entry : {SOLVER_TAKEN, SOLVER_LINEAR})
      device->upload(solver, std::vector<double>{1}, static_cast<std::size_t>(entry));
    device->run(kernels::history_store::Args{.threads = n,
                                             .stride = n,
                                             .displacement = displacement,
                                             .best_iterate = best,
                                             .residual = residual,
                                             .solver = solver,
                                             .history = history});
    device->run(kernels::history_dots::Args{.threads = n,
                                            .stride = n,
                                            .residual = residual,
                                            .preconditioned = image,
                                            .solver = solver,
                                            .history = history,
                                            .history_partial = dots});
    device->run(kernels::history_control::Args{.threads = kernels::history_control::group_size,
                                               .remembers = 1,
                                               .partial_count = partials,
                                               .forget = k == 0,
                                               .largest_scale = 2,
                                               .first_length = 0.25,
                                               .solve_partial = sums,
                                               .history_partial = dots,
                                               .gram = gram,
                                               .solver = solver});
    device->run(kernels::history_direction::Args{.threads = n,
                                                 .remembers = 1,
                                                 .stride = n,
                                                 .solver = solver,
                                                 .preconditioned = image,
                                                 .history = history,
                                                 .best_iterate = best,
                                                 .displacement = displacement});
    const Vector found = vector_of(device->download_real4(displacement)) - u_best;
    const Vector wanted = pairs.empty() ? Vector(0.25 * z) : two_loops(pairs, r, inverse);
    const std::vector<double> state = device->download_real(solver);
    EXPECT_EQ(state[SOLVER_HISTORY], double(pairs.size())) << "iteration " << k;
    EXPECT_EQ(state[SOLVER_LINEAR], 0) << "iteration " << k;
    // 900 products a sum, ten coefficients of sums divided by sums of one sign: a few hundred roundings.
    const double roundings = 400 * GetParam().epsilon();
    EXPECT_LE((found - wanted).norm(), roundings * wanted.norm()) << "iteration " << k;
    EXPECT_NEAR(state[SOLVER_SLOPE], r.dot(wanted), roundings * r.norm() * wanted.norm())
        << "iteration " << k;
    r_best = r;
    u_best = u;
    u = u_best + 0.5 * wanted + 0.05 * draw(-1, 1); // another step than the one proposed
  }
}

// r . z = 4 in all, a quarter of it is the slope: half of that may be gained, or what falls let expect: 2.5
// times the larger, 1.25. Of what was expected before, sixteen iterations forget all, the next 16/17, and
// those after 64 a quarter.
TEST_P(History, EnergyTolerance) {
  const std::unique_ptr<Device> device = GetParam().open();
  const Buffer sums = device->allocate("sums", Type::real4, 1),
               solver = device->allocate("solver", Type::real, SOLVER_ENTRIES);
  device->upload(sums, std::vector<Real4<double>>{{4, 0, 0, 0}});
  struct Case {
    double fall, left, tolerance, error, expected = 0, iterations = 100;
  };
  for (const Case& one :
       {Case{18.75, 0, 0.0626, 0.0625}, Case{18.75, 0, 0.0312, 0.0625}, Case{15, 2, 0.0625, 0.25},
        Case{0, 0, 0.0625, 1}, Case{15, 0, 0, 1}, Case{15, 0, 0.1, 0.25, 20 / 3.0},
        Case{18.75, 0, 0.1, 0.0625, 1.5}, Case{18.75, 0, 0.1, 0.0625, 1e6, 16},
        Case{15, 0, 0.1, 0.25, 85, 17}, Case{15, 0, 0.1, 0.25, 10, 32}}) {
    std::vector<double> state(SOLVER_ENTRIES, 0.0);
    state[SOLVER_LINEAR] = 1;
    state[SOLVER_STOP] = 0.5;
    state[SOLVER_ENERGY_ERROR] = 1;
    state[SOLVER_FALL] = one.fall;
    state[SOLVER_LEFT] = one.left;
    state[SOLVER_EXPECTED] = one.expected;
    state[SOLVER_COUNT] = one.iterations + 1;
    device->upload(solver, state);
    device->run(kernels::history_control::Args{.threads = kernels::history_control::group_size,
                                               .partial_count = 1,
                                               .first_length = 0.25,
                                               .energy_tolerance = one.tolerance,
                                               .solve_partial = sums,
                                               .solver = solver});
    state = device->download_real(solver);
    const bool ends = one.error <= one.tolerance;
    EXPECT_NEAR(state[SOLVER_ENERGY_ERROR], one.error, 4 * GetParam().epsilon());
    EXPECT_EQ(state[SOLVER_STOP], ends);
    EXPECT_EQ(state[SOLVER_REASON], ends);
    EXPECT_EQ(state[SOLVER_ACTION], !ends);
    EXPECT_EQ(state[SOLVER_LINEAR], 0);
  }
}

TEST_P(History, NothingToDescendEndsTheSolve) {
  const std::unique_ptr<Device> device = GetParam().open();
  const Buffer sums = device->allocate("sums", Type::real4, 1),
               solver = device->allocate("solver", Type::real, SOLVER_ENTRIES);
  std::vector<double> state(SOLVER_ENTRIES, 0.0);
  state[SOLVER_LINEAR] = 1;
  device->upload(solver, state);
  device->run(kernels::history_control::Args{.threads = kernels::history_control::group_size,
                                             .partial_count = 1,
                                             .first_length = 1,
                                             .solve_partial = sums,
                                             .solver = solver});
  state = device->download_real(solver);
  EXPECT_EQ(state[SOLVER_STOP], 1);
  EXPECT_EQ(state[SOLVER_REASON], 4);
  EXPECT_EQ(state[SOLVER_LINEAR], 0);
}

} // namespace
} // namespace pliant::test
