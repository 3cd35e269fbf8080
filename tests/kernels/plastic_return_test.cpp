// plastic_return: yield and return of every particle, in each of the regions of the surface.
#include "kernels/plastic_return.h"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(PlasticReturn);

// Scales are those of each step of the formula, from lengths on: two roots, a sum of 26 terms and two
// quotients, a few roundings each; 1.1 seen.
constexpr double limit = 8;

struct Problem {
  BondProblem p;
  Values in;
  std::map<std::string, Expected> wanted;
  std::size_t elastic = 0, cone = 0, apex = 0;

  explicit Problem(std::size_t size) : p("ordinary", size, kernel_seed + 101) {
    Random random(kernel_seed + 102);
    const double equivalent = rounded(std::sqrt(5.)), dimension = 3;
    in = p.bond_values;
    in["equivalent"] = {equivalent};
    in["dimension"] = {dimension};
    in["position"] = p.vectors(p.position);
    in["displacement"] = p.vectors(p.displacement);
    in["rest"] = std::vector<double>(in["weight"].size());
    for (double& value : in["rest"]) value = rounded(1 + random(0.2));
    in["yield"] = p.rows(not_a_number, 8, [&](std::size_t i, std::size_t k) {
      const double row[] = {2 + random(1),
                            i % 3 == 0 ? 0.0 : 3 + random(2),
                            i % 7 == 0 ? 1e30 : 0.3 + random(0.2),
                            i % 2 == 0 ? 0.0 : 0.5 + random(0.4),
                            1e-5 + random(1e-6),
                            p.inverse_modulus[i],
                            1.5 + random(),
                            0};
      return rounded(row[k]);
    });
    in["flow"] = p.rows(not_a_number, 8, [&](std::size_t, std::size_t k) {
      return k == 2 ? random(1e-5) : rounded(std::abs(random(0.2)));
    });
    Expected flow(in["flow"]);
    for (std::size_t i = 0; i < p.count; ++i) expect(i, equivalent, dimension, flow);
    wanted = {{"flow", flow}};
  }

  void expect(std::size_t i, double equivalent, double dimension, Expected& flow) {
    const double* const surface = &in["yield"][8 * (p.first + i)];
    const double* const so_far = &in["flow"][8 * (p.first + i)];
    const double inverse = p.inverse_modulus[i], a_over_b = surface[6];
    struct Term {
      double share, strain, error;
    };
    std::vector<Term> terms;
    for (std::size_t r = 0; r < p.bonds[i].size(); ++r) {
      const auto row = static_cast<std::size_t>(in["slice_begin"][p.first_slice + i / 16]) + r;
      const auto& bond = p.bonds[i][r];
      const double x = bond.reference.norm() * in["rest"][32 * row + i % 16], y = p.current(i, bond).norm();
      terms.push_back({inverse * bond.out * bond.reference.squaredNorm(), (y - x) / x, y / x + 1});
    }
    double iso = 0, iso_error = 0, square = 0, square_error = 0;
    for (const Term& t : terms) iso += t.share * t.strain, iso_error += t.share * t.error;
    for (const Term& t : terms) {
      const double dev = t.strain - iso;
      square += t.share * dev * dev;
      square_error += t.share * (dev * dev + 2 * std::abs(dev) * (t.error + iso_error));
    }
    const double spread = std::sqrt(square);
    const double spread_error = spread > 0 ? square_error / (2 * spread) + spread : 0;
    const double strength = surface[2] + surface[3] * so_far[0], pull = surface[1] * iso;
    const double trial = surface[0] * spread, excess = trial - (strength - pull);
    double alpha = 0, beta = 0, strain = 0, beta_error = 1, alpha_error = 1, strain_error = 0;
    const bool flows = excess > 0;
    const double excess_error =
        surface[0] * spread_error + std::abs(strength) + surface[1] * iso_error + std::abs(pull);
    ++(flows ? cone : elastic);
    if (flows) {
      const double most = equivalent * spread, slope = surface[0] / equivalent + surface[3];
      strain = excess / slope, strain_error = excess_error / slope + strain;
      if (strain < most) {
        beta = strain / most, beta_error = strain_error / most + beta * spread_error / spread;
      } else {
        strain = most, strain_error = equivalent * spread_error;
        beta = 1;
        const double hard = strength + surface[3] * most;
        if (pull > hard) {
          ++apex;
          alpha = std::min((pull - hard) / pull, 1.0);
          alpha_error = (surface[1] * iso_error + hard + surface[3] * strain_error) / pull + 1;
        }
      }
    }
    const double dev2 = beta * (1 - beta) * square, iso2 = alpha * (1 - alpha) * iso * iso;
    const double full = inverse > 0 ? 1 / inverse : 0;
    const double taken_error = full * (square_error + square * beta_error +
                                       a_over_b * (alpha_error * iso * iso + std::abs(iso) * iso_error));
    const std::size_t at = 8 * (p.first + i);
    const double gained = surface[4] * dimension * alpha * iso;
    flow.set(at, so_far[0] + strain, so_far[0] + strain_error);
    flow.set(at + 1, so_far[1] + full * (dev2 + a_over_b * iso2), so_far[1] + (flows ? taken_error : 0));
    flow.set(at + 2, so_far[2] + gained,
             std::abs(so_far[2]) + surface[4] * dimension * (alpha_error * std::abs(iso) + iso_error));
    flow.set(at + 3, flows ? 1 : 0);
    flow.set(at + 4, iso, iso_error);
    flow.set(at + 5, 1 - alpha, alpha_error);
    flow.set(at + 6, 1 - beta, beta_error);
    flow.set(at + 7, std::max(a_over_b, 1.0));
  }
};

TEST_P(PlasticReturn, Formula) {
  for (const std::size_t size : awkward_sizes) {
    const Problem problem(size);
    if (size == 1000) {
      EXPECT_GT(problem.elastic, 50u);
      EXPECT_GT(problem.cone - problem.apex, 50u);
      EXPECT_GT(problem.apex, 50u);
    }
    expect_kernel<kernels::plastic_return::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                 limit);
  }
}

TEST_P(PlasticReturn, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::plastic_return::Args>(GetParam(), Problem(129), {"displacement", 4, 1},
                                                      {"flow", 8});
}

} // namespace
} // namespace pliant::test
