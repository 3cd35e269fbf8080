// chebyshev_step: one accelerated Jacobi iteration, its omega against the recurrence of Wang (2015), and r^2
// / D.
#include "kernels/chebyshev_step.h"
#include "shaders/common/solver.glsl"
#include "shaders/common/touched.glsl"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(ChebyshevStep);

// A division, a product with omega, and omega itself, whose closed form costs an exponential and a logarithm:
// 3 seen in float. In double 11, most of them of the recurrence, which sums its own roundings over 400
// iterations.
constexpr double limit = 30;

// omega of the iteration that is `m` past the plain ones: 1, 2 / (2 - rho^2), 4 / (4 - rho^2 omega).
double recurrence(int m, double rho) {
  double omega = 1;
  for (int k = 1; k <= m; ++k) omega = k == 1 ? 2 / (2 - rho * rho) : 4 / (4 - rho * rho * omega);
  return omega;
}

struct Problem {
  Values in;
  std::map<std::string, Expected> wanted;
  Problem(std::size_t count, bool checked, std::uint32_t iteration, std::uint32_t start, double one_minus_rho,
          bool accelerate = true, bool contacts = false) {
    Random random(kernel_seed + 20);
    constexpr int delay = 10;
    one_minus_rho = rounded(one_minus_rho);
    const double gamma = rounded(0.9);
    std::vector<double> target = random_groups(random, count, 0.01), force = random_groups(random, count, 50);
    for (std::size_t i = 0; i < count; ++i) {
      target[4 * i + 3] = i % 7 == 5 ? -1 : rounded(100 + std::abs(target[4 * i + 3]) * 1e5);
      force[4 * i + 3] = rounded(1000 + std::abs(force[4 * i + 3]) * 100);
    }
    const std::vector<double> u = random_groups(random, count, 0.01),
                              earlier = random_groups(random, count, 0.01);
    std::vector<double> touched(count);
    for (std::size_t i = 0; i < count; ++i) touched[i] = i % 3 == 1;
    std::vector<double> solver(SOLVER_ENTRIES, not_a_number);
    solver[SOLVER_STOP] = 0;
    solver[SOLVER_START] = start;
    solver[SOLVER_DELAY] = delay;
    solver[SOLVER_ACCELERATE] = accelerate;
    solver[SOLVER_ONE_MINUS_RHO] = one_minus_rho;
    solver[SOLVER_GAMMA] = gamma;
    constexpr std::size_t group = kernels::chebyshev_step::group_size;
    const std::size_t groups = (count + group - 1) / group;
    in = {{"checked", {double(checked)}},
          {"iteration", {double(iteration)}},
          {"inertia_target", target},
          {"force", force},
          {"displacement", u},
          {"earlier_iterate", guarded(earlier, 4)},
          {"solver", solver},
          {"contacts", {double(contacts)}},
          {"touched", touched},
          {"residual_partial", std::vector<double>(4 * (groups + behind), sentinel)}};
    const int m = accelerate ? std::max(0, int(iteration) - int(start) - delay + 1) : 0;
    const double omega = recurrence(m, 1 - one_minus_rho);
    Expected next(in["earlier_iterate"]), partial(in["residual_partial"]);
    if (checked)
      for (std::size_t g = 0; g < 4 * groups; ++g) partial.set(g, 0);
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3 now = vector_at(u, i), before = vector_at(earlier, i), goal = vector_at(target, i),
                    f = vector_at(force, i);
      next.set(4 * i + 3, 0);
      if (target[4 * i + 3] < 0) {
        set_vector(next, i, now, Vector3::Zero());
        continue;
      }
      const double inertia = target[4 * i + 3], diagonal = inertia + force[4 * i + 3];
      const Vector3 r = inertia * (goal - now) + f, size_r = inertia * (goal - now).cwiseAbs() + f.cwiseAbs();
      set_vector(next, i, omega * (gamma / diagonal * r + now - before) + before,
                 omega * (gamma / diagonal * size_r + now.cwiseAbs() + before.cwiseAbs()) +
                     before.cwiseAbs());
      if (checked) {
        const std::size_t at = 4 * (i / group);
        const auto add = [&](std::size_t k, double value, double size) {
          partial.value[at + k] += value;
          partial.scale[at + k] += size;
        };
        add(0, r.squaredNorm() / diagonal, r.norm() * size_r.norm() / diagonal);
        const double momentum = (inertia * goal).squaredNorm() / diagonal,
                     moved = diagonal * now.squaredNorm();
        add(1, momentum, momentum);
        add(2, moved, moved);
        const std::uint32_t mixed = static_cast<std::uint32_t>(i) * 2654435761u;
        if (contacts && touched[i] > 0) add(3, TOUCHED_UNIT * (1 + (mixed >> 16)), 0); // exactly
      }
    }
    wanted = {{"earlier_iterate", next}, {"residual_partial", partial}};
  }
};

TEST_P(ChebyshevStep, Formula) {
  for (const std::size_t size : awkward_sizes)
    for (const bool checked : {false, true}) {
      const Problem problem(size, checked, 13, 0, 1e-3, true, size % 2 == 1);
      expect_kernel<kernels::chebyshev_step::Args>(GetParam(), static_cast<std::uint32_t>(size), problem.in,
                                                   problem.wanted, limit);
    }
}

TEST_P(ChebyshevStep, OmegaFollowsTheRecurrence) {
  for (const double one_minus_rho : {1.0, 0.5, 0.01, 1e-4, 1e-7})
    for (const std::uint32_t iteration :
         {0u, 3u, 12u, 13u, 14u, 15u, 16u, 20u, 60u, 400u}) { // 3 + 10 plain ones come first
      const Problem problem(17, false, iteration, 3, one_minus_rho);
      expect_kernel<kernels::chebyshev_step::Args>(GetParam(), 17, problem.in, problem.wanted, limit);
    }
}

TEST_P(ChebyshevStep, PlainJacobi) {
  const Problem problem(17, true, 300, 0, 1e-4, false);
  expect_kernel<kernels::chebyshev_step::Args>(GetParam(), 17, problem.in, problem.wanted, limit);
}

TEST_P(ChebyshevStep, NothingOnceStopped) {
  Problem problem(129, true, 20, 0, 1e-3);
  problem.in["solver"][SOLVER_STOP] = 1;
  const Values out = run_kernel<kernels::chebyshev_step::Args>(OpenDevices::of(GetParam()), 129, problem.in);
  EXPECT_EQ(out.at("earlier_iterate"), problem.in["earlier_iterate"]);
  EXPECT_EQ(out.at("residual_partial"), problem.in["residual_partial"]);
}

TEST_P(ChebyshevStep, NotANumberStaysWhereItIs) {
  Problem problem(300, true, 13, 0, 1e-3);
  Device& device = OpenDevices::of(GetParam());
  const Values clean = run_kernel<kernels::chebyshev_step::Args>(device, 300, problem.in);
  problem.in["force"][4 * 150] = not_a_number;
  const Values spoiled = run_kernel<kernels::chebyshev_step::Args>(device, 300, problem.in);
  expect_contained("earlier_iterate", clean.at("earlier_iterate"), spoiled.at("earlier_iterate"), 4, {150},
                   150);
  expect_contained("residual_partial", clean.at("residual_partial"), spoiled.at("residual_partial"), 4, {1},
                   1);
}

} // namespace
} // namespace pliant::test
