// stretch_force: f_i = sum x (c_ij (phi_i s + G_ij h_i' / 2) + c_ji (phi_j s + G_ji h_j' / 2)) n; the first s
// is 1 where theta is the mean stretch, n that of the reference where two particles coincide, as two of these
// do. And the energy 1/2 sum c x^2 G h, added to what is there.
#include "kernels/stretch_force.h"
#include "tests/kernels/stretch_problem.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(StretchForce);

// The stretch is wrong by two roundings, which h'' carries on; its own dozen operations and the sum add as
// much.
constexpr double limit = 2; // 0.44 seen

struct Problem : StretchProblem {
  std::map<std::string, Expected> wanted;
  Problem(std::size_t size, bool anisotropic, int material = -1, bool potential = false)
      : StretchProblem(size, material) {
    in["potential"] = {double(potential)};
    Random random(kernel_seed + 61);
    in["anisotropic"] = {double(anisotropic)};
    if (!anisotropic) in.erase("strength");
    in["gate"] = {0, 0, 0, 0}; // SOLVER_STOP is down
    std::vector<double> phi(p.count);
    for (double& value : phi) value = random(0.3);
    in["stretch_record"] = p.rows(not_a_number, 8, [&](std::size_t i, std::size_t k) {
      if (k == 3) return phi[i];
      if (k == 7) return first_row(i);
      return k < 3 ? p.displacement[i][static_cast<int>(k)] : p.position[i][static_cast<int>(k - 4)];
    });
    in["linear_start"] = p.rows(
        not_a_number, 4, [](std::size_t i, std::size_t k) { return k < 3 ? sentinel : 7 + double(i); });
    in["force"] = p.buffer(4, sentinel);
    Expected force(in["force"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      Vector3 sum = Vector3::Zero();
      double size_sum = 0;
      for (std::size_t b = 0; b < p.bonds[i].size(); ++b) {
        const auto& bond = p.bonds[i][b];
        const Vector3 y = p.current(i, bond);
        const double x = bond.reference.norm(), length = y.norm(), s = length / x;
        const Vector3 n = length > 0 ? Vector3(y / length) : Vector3(bond.reference / x);
        for (const bool inwards : {false, true}) {
          const std::size_t end = inwards ? bond.to : i;
          const BasisSum& h = energy[kind(end)].bond;
          const double c = inwards ? bond.in : bond.out;
          const double g = anisotropic ? strength(i, b, inwards) : 1;
          sum += x * c * (phi[end] * (kind(end) ? s : 1) + g * h.first(s) / 2) * n;
          double terms = 0;
          for (const BasisTerm& term : h.terms) {
            const BasisSum alone{{term}};
            terms += std::abs(alone.first(s)) + std::abs(alone.second(s)) * (s + 1);
          }
          size_sum += x * c * (std::abs(phi[end]) * (1 + s) + g * terms);
        }
      }
      for (int k = 0; k < 3; ++k)
        force.set(4 * (p.first + i) + static_cast<std::size_t>(k), sum[k], size_sum);
      force.set(4 * (p.first + i) + 3, 7 + double(i));
    }
    wanted = {{"force", force}};
    if (!potential) return;
    in["energy"] =
        p.rows(not_a_number, 1, [](std::size_t i, std::size_t) { return rounded(1e-3 * double(i)); });
    Expected energies(in["energy"]);
    for (std::size_t i = 0; i < p.count; ++i) {
      const Part part = stretching(i, anisotropic);
      energies.set(p.first + i, rounded(1e-3 * double(i)) + part.value, 1e-3 * double(i) + part.size);
    }
    wanted.emplace("energy", energies);
  }
};

TEST_P(StretchForce, Formula) {
  for (const std::size_t size : awkward_sizes)
    for (const bool anisotropic : {false, true})
      for (const int material : {-1, 0, 1})
        for (const bool potential : {false, true}) {
          const Problem problem(size, anisotropic, material, potential);
          expect_kernel<kernels::stretch_force::Args>(GetParam(), problem.p.count, problem.in, problem.wanted,
                                                      potential ? 4
                                                                : limit); // of the energy: as stretch_energy
        }
}

TEST_P(StretchForce, NotANumberReachesNeighboursOnly) {
  expect_nan_contained<kernels::stretch_force::Args>(GetParam(), Problem(129, false),
                                                     {"stretch_record", 8, 3}, {"force", 4});
}

TEST_P(StretchForce, NothingOnceTheSolverHasStopped) {
  Problem problem(17, true);
  problem.in["gate"][0] = 1;
  const Values out =
      run_kernel<kernels::stretch_force::Args>(OpenDevices::of(GetParam()), problem.p.count, problem.in);
  compare_values("force", out.at("force"), problem.in.at("force"),
                 std::vector<double>(out.at("force").size(), 0.0), 0, 0);
}

} // namespace
} // namespace pliant::test
