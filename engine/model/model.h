// A scene as particles and bonds, in double, before any device sees it.
//
// Order of particles: by law, then body, then connected component, then lexicographically along the body's
// lattice (z outermost). A lexicographic order gathers fastest: a particle's neighbours lie in a few straight
// runs. Reference positions are snapped to a grid of spacing / reference_grid in the body's own axes, so that
// a bond's reference vector is three small integers: exact on a lattice, antisymmetric, the same in float and
// double.
#pragma once

#include "engine/model/stretch_energy.h"
#include "engine/scene/sample.h"
#include "engine/scene/scene.h"

#include <cstdint>
#include <string>
#include <vector>

namespace pliant {

/// Reference positions are multiples of spacing / 120; a packed bond vector reaches 511 of them (4.25
/// spacings).
inline constexpr int reference_grid = 120;
/// Bonds are stored in slices of this many particles (SELL-16): one row of a slice is one vector of the CPU.
inline constexpr std::uint32_t slice_width = 16;

enum class Law : std::uint8_t { corotated, ordinary, projective, basis, neo_hookean, fluid };

/// Bonds in rows: particle i has neighbours neighbour[begin[i]] .. neighbour[begin[i+1]-1], in increasing
/// order. Bonds are symmetric: if j is in i's row then i is in j's.
struct Bonds {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> neighbour;
  std::vector<std::uint32_t> reverse; ///< index of the bond (j, i)
  std::vector<double> weight;         ///< omega_ij: normalised, dimensionless, sum over a row is 1
  std::vector<double> strength;       ///< G_ij: stiffness by direction, 1 on average; empty: 1 everywhere
  std::size_t count() const { return neighbour.size(); }
};

/// The constants that a law needs of a material, in Pa; here of solids.
///   corotated:  mu = 3 mu_L,  kappa = (9/2) lambda_L; bond stiffness 2 mu / x^2
///   ordinary:   b = (15/2) mu_L, a = (9/2) K;         bond stiffness 2 b / x^2
///   projective: 2 mu_1 + lambda_1 = 6 E;              bond stiffness (2 mu_1 + lambda_1) / x^2
///   neo-hookean: mu_L, and lambda_L that is raised by mu_L (its small strain then is that of the constants
///   typed); bond stiffness 3 mu_L / x^2
///   basis:      mu_2 = (15/2) mu_L, lambda_2 = (9/2) (lambda_L - mu_L); bond stiffness 2 mu_2 / x^2, times
///   G_ij
struct LawConstants {
  double modulus = 0;  ///< Pa: c_ij = modulus * V_i * omega_ij / x_ij^2 is the bond's own stiffness, N/m
  double coupling = 0; ///< kappa / mu (corotated), (a - b) / b (ordinary), share of the deviatoric term
                       ///< (projective), lambda_2 / mu_2 (basis), 3 lambda_L / (2 mu_L) (neo-hookean)
  double bound = 1;    ///< the solver's diagonal is bound * c_ij: 1 + max(coupling, 0), or 1 (projective), or
                       ///< twice that (neo-hookean)
  double isochoric = 1; ///< the bound without the volume term
};
/// In two dimensions mu_P = 2 mu_L, kappa = 2 lambda', b = 4 mu_L, a = 2 (lambda' + mu_L), basis mu_2 = b and
/// lambda_2 = a - b, where lambda' is lambda_L in plane strain and E nu / (1 - nu^2) in plane stress, whose
/// ratio may reach 0.95; the projective law has ratio 1/4 and 1/3. Throws Error(usage) for what is out of
/// range.
LawConstants law_constants(Law law, double young, double poisson, double split,
                           Neighbourhood neighbourhood = Neighbourhood::solid);
/// The same by a material's own law and calibration. Throws Error(usage).
LawConstants law_constants(const Material& material, Neighbourhood neighbourhood = Neighbourhood::solid);
Law law_from_name(const std::string& name);
/// The law that a material's `law` and `form` name.
Law law_of(const Material& material);
const char* law_name(Law law);

/// One law's run of particles; its bonds begin a new slice.
struct LawRange {
  Law law = Law::corotated;
  std::uint32_t first = 0, count = 0;
  std::uint32_t first_slice = 0;
};

struct BodyModel {
  std::string name;
  std::uint32_t first = 0, count = 0; ///< particles
  Vector3 origin = Vector3::Zero();   ///< m, world; positions are kept relative to it
  Matrix3 axes = Matrix3::Identity(); ///< initial world vector = axes * reference vector
  std::optional<Mesh> surface; ///< the mesh that its particles carry, world position at rest (before `start`)
  std::vector<Vector3>
      surface_reference; ///< the same vertices in the body's axes, relative to the reference origin
  Vector3 color = {0.8, 0.45, 0.3};
  bool self_contact = true;
  bool emitted = false; ///< an emitter's: its particles have no mass until they are born
  double thickness = 0; ///< m; of a sheet, or across the plane of a plane scene; 0: a solid
};

/// A particle held or moved: prescribed while the motion lasts. At most one a particle: later conditions win.
struct Held {
  std::uint32_t particle = 0;
  std::uint32_t motion = 0; ///< index into Model::motions
};
/// A force on a particle while start <= t < end, N.
struct Load {
  std::uint32_t particle = 0;
  Vector3 force = Vector3::Zero();
  double start = 0, end = 1e300;
};

struct WeightReport {
  double worst_residual = 0;       ///< of the moment conditions, relative to the target's norm
  double share_over_5_percent = 0; ///< of particles
  std::size_t signatures = 0;      ///< distinct neighbourhoods solved
};

struct Model {
  double spacing = 0, horizon = 0;  ///< m
  std::vector<Vector3> reference;   ///< m, body axes, snapped; relative to the body's reference origin
  std::vector<Vector3> position;    ///< m, world, at t = 0
  std::vector<Vector3> velocity;    ///< m/s
  std::vector<double> volume, mass; ///< m3, kg
  std::vector<std::uint32_t> body, material, component, id; ///< id: order in which the scene made them
  std::uint32_t components = 0;                             ///< connected by bonds
  Bonds bonds;
  std::vector<LawRange> laws;
  std::vector<BodyModel> bodies;
  /// Of each `material`: those of the scene first, then those of sheets, which are calibrated apart.
  std::vector<LawConstants> constants;
  std::vector<StretchEnergy> stretch;        ///< the same, of law basis; empty sums for the others
  std::vector<std::uint32_t> sheet_material; ///< the material of the scene that each of a sheet was typed as
  unsigned dimension = 3;                    ///< 2: everything stays in the plane z = 0
  std::vector<Motion> motions;
  std::vector<Held> held;
  std::vector<Load> loads;
  WeightReport weight_report;
  std::vector<std::string> warnings; ///< crossing triangles, sparse bodies that were allowed, ...
  std::size_t count() const { return position.size(); }
  bool has_sheets() const { return !sheet_material.empty(); }
};

/// The material of the scene that a particle's was typed as.
inline const Material& typed_material(const Scene& scene, const Model& model, std::size_t particle) {
  const std::uint32_t m = model.material[particle];
  const auto typed = static_cast<std::uint32_t>(scene.materials.size());
  return scene.materials[m < typed ? m : model.sheet_material[m - typed]];
}

/// Builds the particles of a scene. Throws Error(usage): a mesh that will not do, a body with too few
/// particles for its horizon, bodies that overlap (unless allowed), a region that selects no particle,
/// materials of different laws in one body. Regions and conditions select by the rest position, before
/// `deform` and `start`.
Model assemble(const Scene& scene);

/// For tests and library users: one body of given points (body axes = world axes), one material, no
/// conditions. Positions are the snapped ones, so that the body is at rest. Throws Error(usage) for points
/// that coincide.
Model assemble_points(const std::vector<Vector3>& points, double spacing, double horizon_in_spacings,
                      const Material& material, double volume_each, const std::string& weights = "matched",
                      double weight_exponent = -0.7);

/// Bonds between points closer than `horizon` (strictly), rows sorted. Cell grid; O(n).
Bonds find_bonds(const std::vector<Vector3>& points, double horizon);

/// Weights before their moments are matched, as a function of a bond's length r in spacings.
struct Influence {
  enum class Kind : std::uint8_t { power, constant, decreasing, increasing };
  Kind kind = Kind::power;
  double exponent = -0.7; ///< power: r^exponent
  double horizon = 1.87;  ///< spacings; decreasing: (1 + r / horizon)^-1, increasing: r / horizon

  Influence(double power)
      : exponent(power) {} // NOLINT(google-explicit-constructor): a power is the usual one
  Influence(Kind of, double reach) : kind(of), horizon(reach) {}
  double operator()(double r) const;
};
/// Of a scene, for bonds of this horizon (spacings).
Influence influence_of(const SimulationSettings& simulation, double horizon);

/// Fills bonds.weight.
///   "normalised": base weights r^p over their sum.
///   "matched":    non-negative least squares of moments, second (m2: corotated) or fourth (m4: ordinary,
///   projective);
///                 solved once for each distinct neighbourhood of integer bond vectors.
///   `dimension` 2: moments of a disc, in the tangent plane of each neighbourhood.
WeightReport compute_weights(Bonds& bonds, const std::vector<Vector3>& reference, double spacing, Law law,
                             const std::string& weights, const Influence& influence, int dimension = 3);

/// The bonds as devices store them.
struct SlicedBonds {
  std::vector<std::uint32_t>
      slice_begin; ///< offsets into the arrays, multiples of 16; one more than there are slices
  std::vector<std::uint32_t> neighbour; ///< padding: the particle itself
  std::vector<std::uint32_t>
      offset;                     ///< bond vector: three signed 10-bit multiples of spacing / 120, x lowest
  std::vector<double> weight_out; ///< c_ij = modulus_i V_i omega_ij / x^2, N/m; 0 in padding
  std::vector<double> weight_in;  ///< c_ji
  std::vector<double> strength_out, strength_in; ///< G_ij, G_ji; 1 in padding; empty where the model's is
};
SlicedBonds slice_bonds(const Model& model);

/// The solver's stiffness of particle i's half of the bond (i, j) over c_ij: its bound, with G_ij for the
/// bond's own share of it.
double bond_bound(const Model& model, std::size_t i, std::size_t bond);

/// K_i of the diagonal, N/m: sum over bonds of c_ij and c_ji times their bounds.
std::vector<double> diagonal_stiffness(const Model& model);

} // namespace pliant
