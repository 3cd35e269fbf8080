// The work of parting two halves of a material, against sums in closed form: springs, the literature's s0,
// and the corotated law on its lattice.
#include "engine/model/separation.h"
#include "engine/model/failure.h"
#include "tests/failure/broken.h"

#include <numbers>

namespace pliant::test {
namespace {

constexpr double young = 1e6;

BondSet lattice_set(const Material& material, double spacing, double horizon = 1.87) {
  SimulationSettings settings;
  settings.spacing = spacing;
  settings.horizon = horizon;
  return lattice_neighbourhood(settings, material);
}

Separation separation_of(const Material& material, const BondSet& bonds,
                         Neighbourhood neighbourhood = Neighbourhood::solid) {
  return {law_of(material), law_constants(material, neighbourhood), stretch_energy(material, neighbourhood),
          bonds};
}

// b s0^2 <|xi . n|>, in any direction: each bond holds b omega s0^2 in each of its ends' neighbourhoods.
TEST(Separation, OfSpringsIsTheSumOverBonds) {
  const Material material = material_of("ordinary", young, 0.25);
  const BondSet bonds = lattice_set(material, 0.01);
  const Separation parted = separation_of(material, bonds);
  const double modulus = 3 * young; // (15/2) mu
  for (const Vector3& n : {Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(1, 2, 3)}) {
    double reach = 0;
    for (std::size_t b = 0; b < bonds.bond.size(); ++b)
      reach += bonds.weight[b] * std::abs(bonds.bond[b].dot(n.normalized()));
    for (const double stretch : {1e-3, 0.3})
      expect_below("off the sum, relative",
                   std::abs(parted.work(stretch, n.normalized()) / (modulus * stretch * stretch * reach) - 1),
                   1e-9);
  }
}

// Silling and Askari's sqrt(5 G / 9 K delta) and, in plane stress, sqrt(4 pi G / 9 E delta) are those of a
// full ball and disc with weights in proportion to length. Radii by Gauss's rule, directions by many: the
// mean of |cos| by a rule of 24 points is wrong by 4e-4 at most.
TEST(Separation, CriticalStretchIsThatOfTheLiterature) {
  const double delta = 0.01, energy = 80;
  const std::vector<std::array<double, 2>> radii{
      {0.5 - std::sqrt(0.15), 5. / 18}, {0.5, 8. / 18}, {0.5 + std::sqrt(0.15), 5. / 18}};
  Material material = material_of("ordinary", young, 0.25);
  const BondSet sphere = sphere_neighbourhood(material);
  BondSet ball, disc;
  for (const auto& [r, weight] : radii) {
    for (std::size_t d = 0; d < sphere.bond.size(); ++d) {
      ball.bond.emplace_back(delta * r * sphere.bond[d]);
      ball.weight.push_back(weight * 4 * r * r * r * sphere.weight[d]); // w r^2 dr, of sum 1
    }
    for (int k = 0; k < 96; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.5) / 96;
      disc.bond.emplace_back(delta * r * Vector3(std::cos(angle), std::sin(angle), 0));
      disc.weight.push_back(weight * 3 * r * r / 96);
    }
  }
  const double bulk = young / (3 * (1 - 2 * 0.25));
  expect_below("ball, off the literature's stretch",
               std::abs(separation_of(material, ball).critical_stretch(energy, {Vector3::UnitZ()}) /
                            std::sqrt(5 * energy / (9 * bulk * delta)) -
                        1),
               1e-3);
  material.poisson = 1. / 3;
  expect_below("disc, off the literature's stretch",
               std::abs(separation_of(material, disc, Neighbourhood::plane_stress)
                                .critical_stretch(energy, {Vector3::UnitX()}) /
                            std::sqrt(4 * std::numbers::pi * energy / (9 * young * delta)) -
                        1),
               1e-3);
}

// Corotated, without Poisson's ratio, along a face of the lattice of 26 neighbours: nothing turns, and a bond
// that meets the normal at cos bears (s0 / cos)^2 where it is s0 longer, its shear with it.
TEST(Separation, OfCorotatedBondsTakesTheirShearToo) {
  const Material material = material_of("corotated", young, 0);
  const BondSet bonds = lattice_set(material, 0.01);
  const double stretch = 1e-5, mu = 1.5 * young;
  double sum = 0;
  for (std::size_t b = 0; b < bonds.bond.size(); ++b) {
    const double reach = std::abs(bonds.bond[b].z()), cosine = reach / bonds.bond[b].norm();
    if (reach > 0) sum += mu * bonds.weight[b] * std::pow(stretch / cosine, 2) * reach;
  }
  expect_below("off the sum, relative; of second order in the stretch",
               std::abs(separation_of(material, bonds).work(stretch, Vector3::UnitZ()) / sum - 1),
               10 * stretch);
}

// Every law, small and large: the critical stretch is that whose work is the energy; turning the lattice
// and the normal turns nothing.
TEST(Separation, CriticalStretchTakesTheEnergy) {
  for (const Breakable& one : breakable_materials())
    for (const double energy : {1e-4, 1., 300.}) {
      BondSet bonds = lattice_set(one.material, 0.01);
      const Separation parted = separation_of(one.material, bonds);
      const double stretch = parted.critical_stretch(energy, {Vector3::UnitX(), Vector3::UnitY()});
      const double work =
          (parted.work(stretch, Vector3::UnitX()) + parted.work(stretch, Vector3::UnitY())) / 2;
      expect_below(one.name + ": work over the energy, off by", std::abs(work / energy - 1), 1e-8);
      EXPECT_GT(stretch, 0);
      const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
      for (Vector3& bond : bonds.bond) bond = turn * bond;
      expect_below(one.name + ": turned, off by",
                   std::abs(separation_of(one.material, bonds).work(stretch, turn * Vector3::UnitX()) /
                                parted.work(stretch, Vector3::UnitX()) -
                            1),
                   1e-6);
    }
}

TEST(Separation, RefusesLawsThatDoNotBreak) {
  for (const char* law : {"projective", "neo-hookean"}) {
    const Material material = material_of(law, young, 0.3);
    EXPECT_THROW(separation_of(material, lattice_set(material, 0.01)), Error) << law;
  }
}

} // namespace
} // namespace pliant::test
