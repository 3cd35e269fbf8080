// Constants of bonds between fluid particles.
#include "engine/model/fluid_bonds.h"

#include "shaders/common/fluid.glsl"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {

namespace {

constexpr unsigned mixtures = 200; ///< looked at before the best is refined

/// From w0 alone (0) over w2 alone (1) to w4 alone (2).
void mix(double (&weight)[3], double mixture) {
  weight[0] = std::max(1 - mixture, 0.0);
  weight[1] = 1 - std::abs(mixture - 1);
  weight[2] = std::max(mixture - 1, 0.0);
}

/// Calls visit(q, N_1^4 averaged over the axes) for each neighbour on the lattice.
template <class Visit> void for_lattice(const Smoothing& smoothing, double spacing, Visit visit) {
  const int reach = static_cast<int>(smoothing.support / spacing),
            deep = smoothing.dimension == 2 ? 0 : reach;
  for (int z = -deep; z <= deep; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const double square = x * x + y * y + z * z, q = square * std::pow(spacing / smoothing.support, 2);
        if (!(square > 0) || !(q < 1)) continue;
        const double fourth = std::pow(x, 4) + std::pow(y, 4) + std::pow(z, 4);
        visit(q, fourth / (square * square * smoothing.dimension));
      }
}

double fourth_moment(const FluidBonds& bonds, const Smoothing& smoothing, double spacing) {
  double sum = 0, moment = 0;
  for_lattice(smoothing, spacing, [&](double q, double fourth) {
    sum += bond_weight(bonds, q);
    moment += bond_weight(bonds, q) * fourth;
  });
  return moment / sum;
}

void choose_weights(FluidBonds& bonds, const Smoothing& smoothing, double spacing) {
  const double isotropic = smoothing.dimension == 2 ? 3. / 8 : 1. / 5;
  const auto off = [&](double mixture) {
    mix(bonds.weight, mixture);
    return fourth_moment(bonds, smoothing, spacing) - isotropic;
  };
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (unsigned k = 0; k <= mixtures; ++k) {
    const double mixture = 2. * k / mixtures, error = off(mixture);
    if (std::abs(error) < least) best = mixture, least = std::abs(error);
  }
  double low = std::max(best - 2. / mixtures, 0.0), high = std::min(best + 2. / mixtures, 2.0);
  if (off(low) * off(high) < 0) {
    const bool falls = off(low) > 0;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      ((off(middle) > 0) == falls ? low : high) = middle;
    }
    best = (low + high) / 2;
  }
  bonds.isotropy = 1 + off(best) / isotropic;
  double sum = 0;
  for_lattice(smoothing, spacing, [&](double q, double) { sum += bond_weight(bonds, q); });
  for (double& weight : bonds.weight) weight /= sum;
}

} // namespace

double bond_weight(const FluidBonds& bonds, double q) {
  if (q >= 1) return 0;
  return (1 - q) * (1 - q) * (bonds.weight[0] + q * (bonds.weight[1] + q * bonds.weight[2]));
}

FluidBonds fluid_bonds(const Scene& scene, const Model& model, const FluidModel& fluid) {
  FluidBonds bonds;
  if (std::none_of(scene.materials.begin(), scene.materials.end(),
                   [](const Material& material) { return material.bonded(); }))
    return bonds;
  const auto used = [&](std::size_t index) {
    return std::any_of(fluid.kind.begin(), fluid.kind.end(),
                       [&](std::uint32_t kind) { return kind >> FLUID_KIND_SHIFT == index; });
  };
  const Neighbourhood neighbourhood = model.dimension == 3                 ? Neighbourhood::solid
                                      : scene.simulation.plane == "stress" ? Neighbourhood::plane_stress
                                                                           : Neighbourhood::plane_strain;
  bonds.equivalent = std::sqrt(model.dimension == 2 ? 8. / 3 : 5.);
  choose_weights(bonds, fluid.smoothing, fluid.spacing);
  // sum of w / x^2 over the lattice
  double closeness = 0;
  for_lattice(fluid.smoothing, fluid.spacing, [&](double q, double) {
    closeness += bond_weight(bonds, q) / (q * fluid.reach * fluid.reach);
  });
  const double volume = std::pow(fluid.spacing, model.dimension);
  for (const Material& material : scene.materials) {
    if (!material.fluid()) continue;
    FluidElasticity& elastic = bonds.materials.emplace_back();
    elastic.surface.strength = std::numeric_limits<double>::infinity();
    if (!material.bonded() || !used(bonds.materials.size() - 1)) continue;
    const LawConstants constants =
        law_constants(Law::ordinary, material.young, material.poisson, material.split, neighbourhood);
    bonds.any = true;
    elastic.bond = volume * constants.modulus;
    elastic.volumetric = 1 + constants.coupling;
    elastic.relaxation = material.relaxation_time.value_or(0);
    elastic.plastic = material.plastic.given;
    if (elastic.plastic) {
      elastic.surface = yield_surface(material, neighbourhood);
    }
    bonds.plastic = bonds.plastic || elastic.plastic;
    bonds.relaxes = bonds.relaxes || elastic.relaxation > 0;
    bonds.coupled = bonds.coupled || std::abs(constants.coupling) > 1e-12;
    bonds.bound = std::max(bonds.bound, elastic.volumetric);
    bonds.stiffness = std::max(bonds.stiffness, 2 * elastic.bond * std::max(1.0, elastic.volumetric) *
                                                    closeness / (material.density * volume));
  }
  return bonds;
}

} // namespace pliant
