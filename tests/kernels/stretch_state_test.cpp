// stretch_state: phi = (lambda_2 / mu_2) g'(theta) / 2, over theta where that is the root of the mean square;
// and the energy V lambda_2 g(theta).
#include "kernels/stretch_state.h"
#include "tests/kernels/stretch_problem.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(StretchState);

// theta is a sum as in ordinary_state, wrong by about two roundings of its terms; g'' carries that on, and
// its own dozen operations add as much.
constexpr double limit = 1;        // 0.08 seen
constexpr double energy_limit = 4; // as stretch_energy

struct Problem : StretchProblem {
  std::map<std::string, Expected> wanted;
  explicit Problem(std::size_t size, int material = -1, bool potential = false)
      : StretchProblem(size, material) {
    in["potential"] = {double(potential)};
    in.erase("strength");
    in["stride"] = {double(p.total)};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = shape();
    in["gate"] = {0, 0, 0, 0}; // SOLVER_STOP is down
    if (potential) in["energy"] = p.buffer(1, sentinel);
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
    if (!potential) return;
    Expected volume(in["energy"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      const Part part = volumetric(i);
      volume.set(p.first + i, part.value, part.size);
    }
    wanted.emplace("energy", volume);
  }
};

TEST_P(StretchState, Formula) {
  for (const std::size_t size : awkward_sizes)
    for (const int material : {-1, 0, 1})
      for (const bool potential : {false, true}) {
        const Problem problem(size, material, potential);
        expect_kernel<kernels::stretch_state::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                    potential ? energy_limit : limit);
      }
}

TEST_P(StretchState, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::stretch_state::Args>(GetParam(), Problem(129), {"position", 4, 2},
                                                     {"stretch_record", 8});
}

TEST_P(StretchState, NothingOnceTheSolverHasStopped) {
  Problem problem(17);
  problem.in["gate"][0] = 1;
  const Values out =
      run_kernel<kernels::stretch_state::Args>(OpenDevices::of(GetParam()), problem.p.count, problem.in);
  compare_values("stretch_record", out.at("stretch_record"), problem.in.at("stretch_record"),
                 std::vector<double>(out.at("stretch_record").size(), 0.0), 0, 0);
}

} // namespace
} // namespace pliant::test
