// bond_break: a bond longer than either end bears becomes padding at both ends; who loses one gets the share
// of its weights, its count and its diagonal anew, who loses none keeps his bits.
#include "kernels/bond_break.h"
#include "tests/support/kernel_bonds.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(BondBreak);

constexpr double limit = 40; // sums of up to 26 terms, each with a few roundings; 8 seen

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  std::size_t broken = 0;

  explicit Problem(std::size_t size) : p("corotated", size, kernel_seed + 91) {
    Random random(kernel_seed + 92);
    in = p.bond_values;
    in["stride"] = {double(p.total)};
    in["share_row"] = {2};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["shape"] = p.shape(4);
    std::vector<double> border(p.count), bound(p.count);
    for (std::size_t i = 0; i < p.count; ++i) {
      border[i] = rounded(1.5 + random(0.7)); // of the squared stretch
      bound[i] = rounded(1.5 + random(0.5));
      in["shape"][2 * p.total + p.first + i] = 1;
      in["shape"][3 * p.total + p.first + i] = double(i % 3); // broken before
    }
    in["toughness"] = p.rows(not_a_number, 4, [&](std::size_t i, std::size_t k) {
      return k == 0 ? border[i] : k == 1 ? bound[i] : 0;
    });
    in["linear_start"] = p.rows(sentinel, 4, [&](std::size_t, std::size_t k) { return double(k); });
    Expected bond(in["bond"]), weight(in["weight"]), shape(in["shape"]), start(in["linear_start"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      double share = 0, stiffness = 0, lost = 0;
      bool changed = false;
      for (std::size_t r = 0; r < p.bonds[i].size(); ++r) {
        const auto& one = p.bonds[i][r];
        const double x2 = one.reference.squaredNorm(), y2 = p.current(i, one).squaredNorm();
        if (y2 > x2 * std::min(border[i], border[one.to])) {
          changed = true;
          lost += one.out + one.in > 0 ? 1 : 0;
          const auto row = static_cast<std::size_t>(in["slice_begin"][p.first_slice + i / 16]) + r;
          const std::size_t at = 32 * row + i % 16;
          bond.set(at, double(p.first + i)), bond.set(at + 16, 0);
          weight.set(at, 0), weight.set(at + 16, 0);
        } else {
          share += one.out * x2;
          stiffness += bound[i] * one.out + bound[one.to] * one.in;
        }
      }
      if (!changed) continue;
      broken += static_cast<std::size_t>(lost);
      shape.set(2 * p.total + p.first + i, p.inverse_modulus[i] * share, p.inverse_modulus[i] * share);
      shape.set(3 * p.total + p.first + i, double(i % 3) + lost);
      start.set(4 * (p.first + i) + 3, stiffness, stiffness);
    }
    wanted = {{"bond", bond}, {"weight", weight}, {"shape", shape}, {"linear_start", start}};
  }
};

TEST_P(BondBreak, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    EXPECT_EQ(problem.broken % 2, 0u) << "both ends or neither";
    if (size > 100) {
      EXPECT_GT(problem.broken, size) << "the problem should break many bonds";
    }
    expect_kernel<kernels::bond_break::Args>(GetParam(), problem.p.count, problem.in, problem.wanted, limit);
  }
}

// A second time nothing is left to break.
TEST_P(BondBreak, OnceIsEnough) {
  const Problem problem(129);
  Device& device = OpenDevices::of(GetParam());
  const Values once = run_kernel<kernels::bond_break::Args>(device, problem.p.count, problem.in);
  Values in = problem.in;
  for (const auto& [name, values] : once) in[name] = values;
  const Values twice = run_kernel<kernels::bond_break::Args>(device, problem.p.count, in);
  for (const auto& [name, values] : once)
    compare_values(name, twice.at(name), values, std::vector<double>(values.size(), 0.0), 0, 0);
}

} // namespace
} // namespace pliant::test
