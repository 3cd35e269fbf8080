// Energies and stresses of homogeneous deformations: stresses are derivatives, classical laws are what
// textbooks say, and each discrete law follows the curve of the continuum that it stands for.
#include "engine/model/energy_density.h"
#include "engine/report/stress_curve.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace pliant {
namespace {

Material material_of(const std::string& law, double poisson, const std::string& form = "") {
  Material made;
  made.name = made.law = law;
  made.form = form;
  made.young = 1;
  made.poisson = law == "projective" ? 0.25 : poisson;
  return made;
}

Material basis_of(const std::string& name, double poisson, const std::string& calibration = "exact") {
  Material made = material_of("basis", poisson);
  made.volume_basis = made.bond_basis = {{name, 1.0}};
  made.calibration = calibration;
  return made;
}

std::vector<Material> every_law(double poisson) {
  return {material_of("corotated", poisson),
          material_of("ordinary", poisson),
          material_of("projective", poisson),
          material_of("stvk", poisson),
          material_of("stvk", poisson, "bonds"),
          material_of("neo-hookean", poisson),
          material_of("neo-hookean", poisson, "bonds"),
          basis_of("A4", poisson),
          basis_of("B1", poisson)};
}

std::string name_of(const Material& m) {
  return m.law + (m.form.empty() ? "" : ", " + m.form) +
         (m.bond_basis.empty() ? "" : " " + m.bond_basis.begin()->first);
}

std::vector<Matrix3> deformations() {
  Matrix3 sheared, squeezed = Vector3(0.6, 1.3, 1.1).asDiagonal();
  sheared << 1.2, 0.3, 0, -0.1, 0.8, 0.2, 0, 0.1, 1.1;
  const Matrix3 turned = Eigen::AngleAxisd(2.1, Vector3(1, 2, -2) / 3).toRotationMatrix();
  return {Matrix3::Identity(), sheared, turned * sheared, squeezed};
}

SimulationSettings settings() {
  SimulationSettings made;
  made.spacing = 0.1;
  return made;
}

double difference(const std::function<double(const Matrix3&)>& w, const Matrix3& f, int r, int c) {
  const auto at = [&](double t) {
    Matrix3 g = f;
    g(r, c) += t;
    return w(g);
  };
  const double s = 1e-3;
  return (8 * (at(s) - at(-s)) - (at(2 * s) - at(-2 * s))) / (12 * s);
}

TEST(EnergyDensity, StressIsTheDerivativeOfTheEnergy) {
  double worst = 0;
  for (const Material& material : every_law(0.3))
    for (const bool lattice : {true, false}) {
      const EnergyDensity density(material, lattice ? lattice_neighbourhood(settings(), material)
                                                    : sphere_neighbourhood(material, 16));
      EXPECT_NEAR(density.value(Matrix3::Identity()), 0, 1e-15) << name_of(material);
      for (const Matrix3& f : deformations()) {
        const Matrix3 p = density.stress(f);
        for (int k = 0; k < 9; ++k) {
          const double wanted =
              difference([&](const Matrix3& g) { return density.value(g); }, f, k / 3, k % 3);
          worst = std::max(worst, std::abs(p(k / 3, k % 3) - wanted));
          EXPECT_NEAR(p(k / 3, k % 3), wanted, 1e-8) << name_of(material) << " " << k;
        }
      }
    }
  std::printf("  stress against differences of the energy: %.2e E\n", worst);
}

TEST(EnergyDensity, ClassicalStressesAreDerivativesToo) {
  for (const ClassicalLaw law :
       {ClassicalLaw::linear, ClassicalLaw::corotated, ClassicalLaw::stvk, ClassicalLaw::neo_hookean})
    for (const Matrix3& f : deformations())
      for (int k = 0; k < 9; ++k)
        EXPECT_NEAR(
            classical_stress(law, 1, 0.3, f)(k / 3, k % 3),
            difference([&](const Matrix3& g) { return classical_energy(law, 1, 0.3, g); }, f, k / 3, k % 3),
            1e-8)
            << classical_name(law) << " " << k;
}

// Small strains: energy lambda / 2 (tr e)^2 + mu e : e of the constants typed, for every law.
TEST(EnergyDensity, SmallStrainsAreThoseOfTheConstantsTyped) {
  Matrix3 strain;
  strain << 2, 0.5, -1, 0.5, -1, 0.3, -1, 0.3, 0.7;
  const double size = 1e-5;
  for (const double poisson : {0.0, 0.3, 0.45})
    for (const Material& material : every_law(poisson)) {
      const EnergyDensity density(material, sphere_neighbourhood(material, 16));
      const double wanted = classical_energy(ClassicalLaw::linear, 1, material.poisson,
                                             Matrix3::Identity() + size * strain),
                   got = density.value(Matrix3::Identity() + size * strain);
      EXPECT_NEAR(got / wanted, 1, 2e-4) << name_of(material) << " " << poisson;
    }
}

// The corotated law is corotated linear elasticity, and the exact St. Venant-Kirchhoff law that of textbooks,
// for every homogeneous deformation.
TEST(EnergyDensity, ExactLawsAreTheClassicalOnes) {
  for (const auto& [law, classical] :
       {std::pair{"corotated", ClassicalLaw::corotated}, {"stvk", ClassicalLaw::stvk}})
    for (const double poisson : {0.0, 0.25, 0.4})
      for (const Matrix3& f : deformations()) {
        const Material material = material_of(law, poisson);
        const EnergyDensity sphere(material, sphere_neighbourhood(material, 16)),
            lattice(material, lattice_neighbourhood(settings(), material));
        const Matrix3 wanted = classical_stress(classical, 1, poisson, f);
        EXPECT_LT((sphere.stress(f) - wanted).norm(), 1e-11) << law;
        EXPECT_LT((lattice.stress(f) - wanted).norm(), law == std::string("stvk") ? 0.01 : 1e-9) << law;
      }
}

struct Row {
  double poisson, s;
  double neo_hookean[2], stvk[2], bonds[2], paper[2], ordinary[2], paper_linear[2]; ///< P / E, t
};

// Uniaxial tension of the continuum, found apart from this code to the digits given.
constexpr Row table[] = {
    {.25, .5, {-.900, 1.173}, {-.188, 1.090}, {-.412, 1.130}, {-.416, 1.153}, {-.328, 1.115}, {-.338, 1.144}},
    {.25, .8, {-.237, 1.056}, {-.144, 1.044}, {-.190, 1.051}, {-.198, 1.065}, {-.177, 1.049}, {-.186, 1.063}},
    {.25, 1.2, {.176, .954}, {.264, .943}, {.206, .952}, {.227, .932}, {.220, .949}, {.238, .931}},
    {.25, 1.6, {.445, .883}, {1.248, .781}, {.632, .873}, {.751, .794}, {.753, .846}, {.842, .777}},
    {.25, 2.0, {.663, .828}, {3.00, .500}, {1.038, .819}, {1.346, .662}, {1.373, .745}, {1.588, .611}},
    {.4, .8, {-.246, 1.092}, {-.144, 1.070}, {-.182, 1.076}, {-.183, 1.078}, {-.172, 1.075}, {-.174, 1.078}},
    {.4, 1.2, {.172, .929}, {.264, .908}, {.218, .917}, {.222, .912}, {.226, .915}, {.230, .911}},
    {.4, 1.6, {.420, .823}, {1.248, .613}, {.758, .737}, {.797, .714}, {.827, .715}, {.847, .698}},
};

StressPoint pulled(const StressFunction& stress, double s) {
  return stress_points(StressTest::uniaxial, stress, {s}, 1).front();
}

StressPoint pulled(const Material& material, double s) {
  const EnergyDensity density(material, sphere_neighbourhood(material, 24));
  return pulled([&](const Matrix3& f) { return density.stress(f); }, s);
}

TEST(EnergyDensity, FollowsTheTableOfUniaxialTension) {
  for (const Row& row : table) {
    const auto closed = [&](ClassicalLaw law) {
      return pulled([&](const Matrix3& f) { return classical_stress(law, 1, row.poisson, f); }, row.s);
    };
    const struct {
      const char* column;
      StressPoint point;
      const double* wanted;
    } all[] = {
        {"neo-Hookean", closed(ClassicalLaw::neo_hookean), row.neo_hookean},
        {"St. Venant-Kirchhoff", closed(ClassicalLaw::stvk), row.stvk},
        {"neo-hookean, bonds", pulled(material_of("neo-hookean", row.poisson, "bonds"), row.s), row.bonds},
        {"A1, xu2018", pulled(basis_of("A1", row.poisson, "xu2018"), row.s), row.paper},
        {"ordinary", pulled(material_of("ordinary", row.poisson), row.s), row.ordinary},
        {"B1, xu2018", pulled(basis_of("B1", row.poisson, "xu2018"), row.s), row.paper_linear}};
    for (const auto& [column, point, wanted] : all) {
      EXPECT_NEAR(point.stress, wanted[0], 0.0006 * std::max(1.0, wanted[0]))
          << row.poisson << " " << row.s << " " << column;
      EXPECT_NEAR(point.lateral, wanted[1], 0.0006) << row.poisson << " " << row.s << " " << column;
    }
  }
}

// St. Venant and Kirchhoff in tension: P = E s (s^2 - 1) / 2, t^2 = 1 - nu (s^2 - 1).
TEST(EnergyDensity, SaintVenantKirchhoffInTension) {
  for (const double s : {0.5, 0.8, 1.2, 1.6}) {
    const StressPoint point = pulled(material_of("stvk", 0.3), s);
    EXPECT_NEAR(point.stress, s * (s * s - 1) / 2, 1e-9);
    EXPECT_NEAR(point.lateral, std::sqrt(1 - 0.3 * (s * s - 1)), 1e-9);
  }
  // Beyond s^2 = 1 + 1 / nu the sides have vanished: there is no equilibrium, and none is made up.
  EXPECT_TRUE(std::isnan(pulled(material_of("stvk", 0.4), 1.95).stress));
}

// The curve of a lattice against that of the continuum. Matched weights give 26 bonds the continuum's moments
// up to the fourth, which laws over bonds need at small strain: within 2 % for stretches of 0.95 to 1.05.
// What they are off beyond, and what the classical law is away, is printed, not judged, except for the laws
// that claim to be exact.
TEST(EnergyDensity, LatticesFollowTheirContinuum) {
  Scene scene;
  scene.simulation = settings();
  for (const double poisson : {0.0, 0.25, 0.4})
    for (const Material& one : every_law(poisson)) {
      Material named = one;
      named.name = name_of(one);
      scene.materials = {named};
      const StressCurveReport report = stress_curves(scene, {});
      for (const StressCurve& curve : report.materials[0].curves) {
        double from_continuum = 0, near_rest = 0, from_closed = 0;
        for (std::size_t k = 0; k < report.stretches.size(); ++k) {
          const StressPoint &l = curve.lattice[k], &c = curve.continuum[k];
          const double away = std::abs(report.stretches[k] - 1);
          if (away < 0.11) {
            EXPECT_TRUE(std::isfinite(l.stress)) << named.name << " " << report.stretches[k];
          }
          if (away < 1e-9 || !std::isfinite(l.stress) || !std::isfinite(c.stress)) continue;
          from_continuum = std::max(from_continuum, std::abs(l.stress / c.stress - 1));
          if (away < 0.06) near_rest = std::max(near_rest, std::abs(l.stress / c.stress - 1));
          if (!curve.closed.empty() && std::isfinite(curve.closed[k].stress))
            from_closed = std::max(from_closed, std::abs(l.stress / curve.closed[k].stress - 1));
        }
        std::printf("  %-20s nu %.2f %-12s lattice from continuum %7.3f %% (0.95 to 1.05: %.3f %%), from %s "
                    "%.2f %%\n",
                    named.name.c_str(), named.poisson, stress_test_name(curve.test), 100 * from_continuum,
                    100 * near_rest,
                    report.materials[0].closed_name.empty() ? "-" : report.materials[0].closed_name.c_str(),
                    100 * from_closed);
        EXPECT_LT(near_rest, 0.02) << named.name << " " << stress_test_name(curve.test);
        if (named.law == "corotated" || (named.law == "stvk" && named.form.empty())) {
          EXPECT_LT(from_closed, 0.01) << named.name << " " << stress_test_name(curve.test);
        }
      }
    }
}

} // namespace
} // namespace pliant
