// plastic_flow: rest lengths that leave each bond the strain that stays; the same bits in both particles'
// rows.
#include "kernels/plastic_flow.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(PlasticFlow);

// A length, four products and two quotients, of which the scales have the amplification; a sum of 26 pairs.
// 2 seen.
constexpr double limit = 8;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;

  std::size_t entry(std::size_t i, std::size_t r) const {
    return 32 * (static_cast<std::size_t>(in.at("slice_begin")[p.first_slice + i / 16]) + r) + i % 16;
  }
  static double rest_of(std::size_t i, std::size_t j) {
    return rounded(0.8 + 0.4 * static_cast<double>((31 * i + 17 * j) % 101) / 100);
  }

  explicit Problem(std::size_t size) : p("ordinary", size, kernel_seed + 103, true) {
    Random random(kernel_seed + 104);
    in = p.bond_values;
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["rest"] = std::vector<double>(in["weight"].size(), 1.0);
    in["flow"] = p.rows(not_a_number, 8, [&](std::size_t i, std::size_t k) {
      const bool flows = i % 3 != 0;
      const double row[] = {0,
                            0,
                            0,
                            0,
                            random(0.1),
                            flows && i % 4 == 0 ? 0.5 + random(0.5) : 1,
                            flows ? 0.5 + random(0.5) : 1,
                            1.5 + random(0.5)};
      return rounded(row[k]);
    });
    in["linear_start"] = p.rows(sentinel, 4, [&](std::size_t, std::size_t k) { return double(k); });
    for (std::size_t i = 0; i < p.count; ++i)
      for (std::size_t r = 0; r < p.bonds[i].size(); ++r) {
        in["rest"][entry(i, r)] = rest_of(i, p.bonds[i][r].to);
        in["rest"][entry(i, r) + 16] = rest_of(p.bonds[i][r].to, i);
      }
    Expected rest(in["rest"]), start(in["linear_start"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      double stiffness = 0, error = 0;
      bool changed = false;
      for (std::size_t r = 0; r < p.bonds[i].size(); ++r) {
        const auto& bond = p.bonds[i][r];
        for (const bool other : {false, true}) {
          const std::size_t at = entry(i, r) + (other ? 16 : 0), whose = other ? bond.to : i;
          const double* const stays = &in["flow"][8 * (p.first + whose) + 4];
          const double x = bond.reference.norm(), y = p.current(i, bond).norm(), before = in["rest"][at];
          double after = before, scale = 0;
          if (stays[1] < 1 || stays[2] < 1) {
            changed = true;
            const double stretch =
                std::max(1 + stays[1] * stays[0] + stays[2] * (y / (x * before) - 1 - stays[0]), 0.05);
            after = y / (x * stretch);
            scale = after * (3 + (2 + y / (x * before) + std::abs(stays[0])) / stretch);
            after = std::clamp(after, 0.05, 20.0);
            rest.set(at, after, std::max(scale, after));
          }
          const double term = stays[3] * (other ? bond.in : bond.out) / (after * after);
          stiffness += term, error += term * (2 + 2 * scale / after);
        }
      }
      if (changed) start.set(4 * (p.first + i) + 3, stiffness, error);
    }
    wanted = {{"rest", rest}, {"linear_start", start}};
  }
};

TEST_P(PlasticFlow, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    const Values out = expect_kernel<kernels::plastic_flow::Args>(GetParam(), problem.p.count, problem.in,
                                                                  problem.wanted, limit);
    // Both directions of a bond.
    const auto& bonds = problem.p.bonds;
    std::size_t compared = 0;
    for (std::size_t i = 0; i < bonds.size(); ++i)
      for (std::size_t r = 0; r < bonds[i].size(); ++r) {
        const std::size_t j = bonds[i][r].to;
        for (std::size_t back = 0; back < bonds[j].size(); ++back)
          if (bonds[j][back].to == i) {
            EXPECT_EQ(out.at("rest")[problem.entry(i, r)], out.at("rest")[problem.entry(j, back) + 16]);
            ++compared;
          }
      }
    if (size > 100) {
      EXPECT_GT(compared, size);
    }
  }
}

TEST_P(PlasticFlow, WhatStaysWholeKeepsItsBits) {
  Problem problem(129);
  for (std::size_t i = 0; i < problem.p.count; ++i)
    problem.in["flow"][8 * (problem.p.first + i) + 5] = problem.in["flow"][8 * (problem.p.first + i) + 6] = 1;
  const Values out =
      run_kernel<kernels::plastic_flow::Args>(OpenDevices::of(GetParam()), problem.p.count, problem.in);
  for (const char* name : {"rest", "linear_start"})
    compare_values(name, out.at(name), problem.in[name], std::vector<double>(out.at(name).size(), 0.0), 0, 0);
}

} // namespace
} // namespace pliant::test
