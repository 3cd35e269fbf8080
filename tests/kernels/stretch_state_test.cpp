// stretch_state: phi = (lambda_2 / mu_2) g'(theta) / 2, over theta where that is the root of the mean square.
#include "kernels/stretch_state.h"
#include "tests/kernels/stretch_problem.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(StretchState);

// theta is a sum as in ordinary_state, wrong by about two roundings of its terms; g'' carries that on, and
// its own dozen operations add as much.
constexpr double limit = 1; // 0.08 seen

struct Problem : StretchProblem {
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size, int material = -1) : StretchProblem(size, material) {
    in.erase("strength");
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = shape();
    in["solver"] = solver_running;
    in["stretch_record"] = p.buffer(8, sentinel);
    Expected record(in["stretch_record"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      const Dilatation d = dilatation(i);
      const BasisSum& g = energy[kind(i)].volume;
      const double theta = 1 + d.e, per = kind(i) ? 1 / theta : 1;
      double terms = 0;
      for (const BasisTerm& term : g.terms) {
        const BasisSum alone{{term}};
        terms += std::abs(alone.second(theta)) * (d.size + 1) + std::abs(alone.first(theta));
      }
      const std::size_t at = 8 * (p.first + i);
      for (std::size_t k = 0; k < 3; ++k) {
        record.set(at + k, p.displacement[i][static_cast<int>(k)]);
        record.set(at + 4 + k, p.position[i][static_cast<int>(k)]);
      }
      record.set(at + 3, per * g.first(theta) / 2, per * terms);
      record.set(at + 7, first_row(i));
    }
    wanted = {{"stretch_record", record}};
  }
};

TEST_P(StretchState, Formula) {
  for (const std::size_t size : awkward_sizes)
    for (const int material : {-1, 0, 1}) {
      const Problem problem(size, material);
      expect_kernel<kernels::stretch_state::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                  limit);
    }
}

TEST_P(StretchState, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::stretch_state::Args>(GetParam(), Problem(129), {"position", 4, 2},
                                                     {"stretch_record", 8});
}

TEST_P(StretchState, NothingOnceTheSolverHasStopped) {
  expect_nothing_when_stopped<kernels::stretch_state::Args>(GetParam(), Problem(17), "stretch_record");
}

} // namespace
} // namespace pliant::test
