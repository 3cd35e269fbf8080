// statistics_chunk: energies, momentum and the largest values of each chunk; what is not finite is counted,
// and leaves the largest values alone.
#include "kernels/statistics_chunk.h"
#include "tests/support/kernel_components.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(StatisticsChunk);

constexpr double limit = 20; // a chain of up to 540 sums of one sign on the CPU; 5 seen in float

struct Problem {
  ComponentProblem p{{1, 15, 17, 127, 129, 1000}, kernel_seed + 36, 0.01, 0.02};
  Values in;
  Problem() {
    Random random(kernel_seed + 37);
    in = {{"energies", {1}},
          {"chunk", p.chunk},
          {"position", p.position},
          {"velocity", random_groups(random, p.count, 3)},
          {"displacement", p.displacement},
          {"chunk_sum", guarded(std::vector<double>(8 * p.chunks, 1.0), 4)}};
    for (std::size_t i = 0; i < p.count; ++i) in["energy"].push_back(std::abs(random(2)));
  }
  std::uint32_t threads() const {
    return static_cast<std::uint32_t>(p.chunks) * kernels::statistics_chunk::group_size;
  }
};

TEST_P(StatisticsChunk, Formula) {
  Problem problem;
  const ComponentProblem& p = problem.p;
  Expected sum(problem.in["chunk_sum"]);
  for (std::size_t g = 0; g < p.chunks; ++g) {
    double kinetic = 0, elastic = 0, speed2 = 0, shift2 = 0, size_momentum = 0;
    Vector3 momentum = Vector3::Zero();
    for (auto i = static_cast<std::size_t>(p.chunk[4 * g]); i < static_cast<std::size_t>(p.chunk[4 * g + 1]);
         ++i) {
      const Vector3 v = vector_at(problem.in["velocity"], i);
      kinetic += p.mass(i) * v.squaredNorm() / 2;
      elastic += problem.in["energy"][i];
      momentum += p.mass(i) * v;
      size_momentum += p.mass(i) * v.norm();
      speed2 = std::max(speed2, v.squaredNorm());
      shift2 = std::max(shift2, vector_at(p.displacement, i).squaredNorm());
    }
    sum.set(8 * g, kinetic, kinetic);
    sum.set(8 * g + 1, elastic, elastic);
    sum.set(8 * g + 2, speed2, speed2);
    sum.set(8 * g + 3, 0);
    set_vector(sum, 2 * g + 1, momentum, Vector3::Constant(size_momentum));
    sum.set(8 * g + 7, shift2, shift2);
  }
  expect_kernel<kernels::statistics_chunk::Args>(GetParam(), problem.threads(), problem.in,
                                                 {{"chunk_sum", sum}}, limit);
}

TEST_P(StatisticsChunk, CountsWhatIsNotFinite) {
  Problem problem;
  Device& device = OpenDevices::of(GetParam());
  const Values clean = run_kernel<kernels::statistics_chunk::Args>(device, problem.threads(), problem.in);
  const std::size_t g = problem.p.chunks - 1, first = static_cast<std::size_t>(problem.p.chunk[4 * g]);
  problem.in["position"][4 * first + 2] = not_a_number;
  problem.in["velocity"][4 * (first + 1)] = anything;
  problem.in["energy"][first + 2] = not_a_number;
  problem.in["displacement"][4 * (first + 3) + 1] = -anything;
  problem.in["displacement"][4 * (first + 3) + 2] = not_a_number; // one particle, counted once
  const Values spoiled = run_kernel<kernels::statistics_chunk::Args>(device, problem.threads(), problem.in);
  EXPECT_EQ(spoiled.at("chunk_sum")[8 * g + 3], 4);
  for (const std::size_t k : {2, 7}) {
    EXPECT_TRUE(std::isfinite(spoiled.at("chunk_sum")[8 * g + k]));
    EXPECT_LE(spoiled.at("chunk_sum")[8 * g + k], clean.at("chunk_sum")[8 * g + k]);
    EXPECT_GT(spoiled.at("chunk_sum")[8 * g + k], 0);
  }
  for (std::size_t k = 0; k < 8 * g; ++k) EXPECT_EQ(spoiled.at("chunk_sum")[k], clean.at("chunk_sum")[k]);
}

TEST_P(StatisticsChunk, WithoutEnergiesNoneIsRead) {
  Problem problem;
  Device& device = OpenDevices::of(GetParam());
  const Values with = run_kernel<kernels::statistics_chunk::Args>(device, problem.threads(), problem.in);
  problem.in["energies"] = {0};
  for (double& e : problem.in["energy"]) e = not_a_number;
  const Values without = run_kernel<kernels::statistics_chunk::Args>(device, problem.threads(), problem.in);
  for (std::size_t k = 0; k < 8 * problem.p.chunks; ++k)
    EXPECT_EQ(without.at("chunk_sum")[k], k % 8 == 1 ? 0 : with.at("chunk_sum")[k]) << k;
}

} // namespace
} // namespace pliant::test
