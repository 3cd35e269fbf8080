// A scene as its TOML file says it: names and SI units, nothing derived. scene_parse.cpp fills it in,
// scene_schema.cpp lists its keys, model/assemble.cpp turns it into particles.
#pragma once

#include <Eigen/Core>

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

/// A solid to fill with particles, a region to select some, or an obstacle. `at` is the centre.
struct Shape {
  enum class Kind { box, sphere, cylinder, torus, mesh, plane, sheet };
  Kind kind = Kind::box;
  Vector3 at = Vector3::Zero();   ///< m; centre (of a mesh: of its bounding box)
  Vector3 size = Vector3::Ones(); ///< m; box: edge lengths
  double radius = 0;              ///< m; sphere, cylinder; torus: of the ring
  double tube = 0;                ///< m; torus: of the tube
  double height = 0;              ///< m; cylinder
  Vector3 normal = {0, 1, 0};     ///< plane: unit normal, pointing to the free side
  double offset = 0;              ///< m; plane: points x with normal . x = offset
  std::string mesh;               ///< file name as typed
  /// m; sheet: width along x, height along y
  std::optional<std::array<double, 2>> sheet;
  std::optional<double> fit;       ///< m; mesh: longest side of its box after scaling
  std::optional<Vector3> place;    ///< mesh: `at` was given (else the mesh stays where its file puts it)
  Vector3 rotate_axis = {0, 1, 0}; ///< unit
  double rotate_degrees = 0;       ///< about `at`
};

/// A rigid motion: x(t) = c + R(t)(x0 - c) + velocity t, R about `axis` through `about`.
struct Motion {
  Vector3 velocity = Vector3::Zero(); ///< m/s
  Vector3 axis = {0, 1, 0};           ///< unit
  Vector3 about = Vector3::Zero();    ///< m; a point of the axis
  double rate = 0;                    ///< rad/s
  double start = 0;                   ///< s
  double end = 1e300;                 ///< s; it stands still afterwards
  std::optional<bool> release;        ///< instead, at `end`, particles are set free and an obstacle is gone
};

/// Stiffness of bonds by direction: |Sigma R^T N| over its mean, the columns of R the directions.
struct Anisotropy {
  bool given = false;
  Vector3 strengths = Vector3::Ones();      ///< sigma: along each direction, above 0
  Matrix3 directions = Matrix3::Identity(); ///< rows: orthonormal, in the scene's axes, of the body at rest
  Vector3 rotate_axis = {0, 1, 0};          ///< unit; the directions turned about it
  double rotate_degrees = 0;
  bool around = false;                      ///< instead: radial, tangential and axial about an axis
  Vector3 around_axis = {0, 1, 0};          ///< unit
  Vector3 around_through = Vector3::Zero(); ///< m; a point of it
};

/// Drucker-Prager plasticity: what a material bears before it flows; see engine/model/plasticity.h.
struct Plasticity {
  bool given = false;
  double cohesion = 0;  ///< Pa
  double friction = 0;  ///< rad, internal; 0: von Mises
  double hardening = 0; ///< Pa of cohesion gained by a unit of equivalent plastic strain
};

struct Material {
  std::string name;
  std::string model = "elastic";
  std::string law = "corotated"; ///< "corotated" M4, "ordinary" M2, "projective" M1; of Xu et al. (2018):
                                 ///< "basis", "stvk", "neo-hookean"
  std::string form;              ///< "stvk", "neo-hookean": "exact" or "bonds"; empty: the law's default
  std::map<std::string, double> volume_basis,
      bond_basis;                    ///< "basis" only: shares of g and h, such as "A4": 0.5
  std::string calibration = "exact"; ///< "basis", "stvk": or "xu2018" (Eq. 26)
  Anisotropy anisotropy;             ///< laws over bonds
  double density = 1000;             ///< kg/m3
  double young = 1e5;                ///< Pa
  double poisson = 0.3;
  double split = 0.5;             ///< M1 only: share of the deviatoric term, 0 to 1
  std::string inversion = "none"; ///< laws over bonds: "none" or "clamp"; M1: "clamp", also where this says
                                  ///< "none", or "swap" (the paper's row swap; fails by design)
  Vector3 color = {0.8, 0.45, 0.3};
  bool color_given = false;
  // Failure: at most one of them; neither, and bonds never break.
  std::optional<double> fracture_energy;  ///< J/m2, to cut a unit of area
  std::optional<double> critical_stretch; ///< bonds break beyond a length of (1 + this) times the one at rest
  bool breaks() const { return fracture_energy || critical_stretch; }
  Plasticity plastic; ///< law "ordinary"
  // Models "fluid" and "viscoelastic"; of the former nothing of the above but density and colour.
  double viscosity = 0;        ///< Pa s
  double redistribution = 0;   ///< 0 to 1: how strongly particles spread evenly
  double surface_tension = 0;  ///< pull on particles of the surface, dimensionless
  double tensile_strength = 0; ///< Pa: pressure below none that its inside bears
  bool fluid() const { return model == "fluid" || bonded(); }
  // Model "viscoelastic": a fluid whose particles are bonded to the neighbours they have now.
  std::optional<double> relaxation_time; ///< s, of the deviatoric stress; nothing: it stays
  bool bonded() const { return model == "viscoelastic"; }
};

/// Whether the material's law feels lengths only, so that a neighbourhood may stay inverted unless it is
/// pushed back.
inline bool may_invert(const Material& material) {
  return material.law != "corotated" && (material.law != "neo-hookean" || material.form == "bonds");
}

/// Whether bonds of the material's law can break: those of laws with shape tensors cannot.
inline bool may_break(const Material& material) {
  return material.law != "projective" && (material.law != "neo-hookean" || material.form == "bonds");
}

/// Part of a body held, moved or loaded.
struct Condition {
  enum class Kind { fixed, moved, loaded };
  Kind kind = Kind::fixed;
  Shape region;                    ///< in the body's initial position
  Motion motion;                   ///< moved
  Vector3 force = Vector3::Zero(); ///< N in total, shared by mass; loaded
  double start = 0, end = 1e300;   ///< s; loaded
};

struct MaterialRegion {
  Shape region;
  std::string material;
};

/// A piece of a plane, as a thin box, across which a body has no bonds: a notch.
struct Cut {
  Shape region; ///< in the body's initial position
};

/// Part of a body that starts deformed: y = c + F (x - c) of its rest positions.
struct DeformedRegion {
  Shape region;                         ///< in the body's rest position
  Matrix3 deform = Matrix3::Identity(); ///< F
  std::optional<Vector3> about;         ///< m; c, by default the centre of mass of these particles
};

struct Body {
  std::string name;
  std::string material;
  Shape shape;
  Vector3 velocity = Vector3::Zero();  ///< m/s
  Vector3 spin = Vector3::Zero();      ///< rad/s, about the centre of mass
  std::vector<MaterialRegion> regions; ///< later ones win
  std::vector<Condition> conditions;
  std::vector<Cut> cuts;
  std::vector<DeformedRegion> deformed; ///< in this order, before `deform` and `start`
  /// Initial deformation of the particles about the centre of mass: y = c + F (x - c). Identity by default.
  Matrix3 deform = Matrix3::Identity();
  std::string start = ""; ///< "", "flat" (onto the plane x = c), "line", "point", "random", "mirror"
  std::optional<Vector3> color;
  bool self_contact = true;
  /// m; of a sheet or, where `dimension` is 2, of the body across the plane (1 by default).
  std::optional<double> thickness;
  std::optional<double> horizon; ///< spacings; by default the scene's
  std::string typed_at; ///< ":line:column" of its shape in the scene's file; empty where it is not from one
};

/// An obstacle that particles may not enter.
struct Boundary {
  std::string name;
  Shape shape;
  bool inside = false; ///< keep particles inside instead of outside (box, sphere, mesh)
  bool slip = true;
  double friction = 0.0; ///< Coulomb coefficient where slip
  Motion motion;
  bool visible = true;
  std::string typed_at; ///< as Body::typed_at
};

/// A nozzle from which a fluid comes, layer by layer; see engine/model/emission.h.
struct Emitter {
  std::string name, material;
  std::optional<double> disc;                     ///< m; radius of the nozzle, or
  std::optional<std::array<double, 2>> rectangle; ///< m; its edges, the first along `along`
  Vector3 at = Vector3::Zero();                   ///< m; its middle
  Vector3 direction = {0, -1, 0};                 ///< unit; of what comes out
  std::optional<Vector3> along;                   ///< unit
  double speed = 0;                               ///< m/s
  double start = 0, stop = 1e300;                 ///< s
  std::optional<unsigned> particles;              ///< at most
  bool stops = false;                             ///< where the scene is full it ends; otherwise the run does
  std::optional<Vector3> color;
  std::string typed_at; ///< ":line:column" of the nozzle
};

/// Where particles of fluids are taken out.
struct Sink {
  std::string name;
  Shape region;
  std::string typed_at; ///< as Emitter::typed_at
};

struct SimulationSettings {
  double spacing = 0;               ///< m, between particles; required
  double horizon = 1.87;            ///< in spacings
  double time_step = 1.0 / 60;      ///< s
  double end = 1;                   ///< s
  Vector3 gravity = {0, -9.81, 0};  ///< m/s2
  std::string weights = "matched";  ///< "matched" (m2 or m4 as the law needs) or "normalised"
  double weight_exponent = -0.7;    ///< base influence r^p
  std::string influence = "power";  ///< of base weights; see Influence of model.h
  unsigned dimension = 3;           ///< 2: everything lies and moves in the plane z = 0
  std::string plane = "strain";     ///< dimension 2: what is zero across the plane, "strain" or "stress"
  std::optional<unsigned> capacity; ///< particles that there may be at once, with emitters
  std::string capacity_at;          ///< ":line:column" of it
};

struct SolverSettings {
  std::string method = "auto";         ///< see engine/plan/method.h
  std::string preconditioner = "auto"; ///< of lbfgs and newton
  double tolerance = 1e-3;             ///< relative residual
  /// Of Eq. 25 of Xu et al. (2018): what ends a step instead of `tolerance`, where there is a line search on
  /// a potential.
  std::optional<double> energy_tolerance;
  bool energy_assumed = false;               ///< no key: it was not typed, the material laws ask for it
  unsigned iterations = 1000;                ///< a cap
  std::string integrator = "implicit-euler"; ///< or "bdf2"
  double under_relaxation = 0.9;             ///< of each Jacobi update, 0 to 1
  unsigned delay = 10;                       ///< plain iterations before acceleration
  std::optional<double> spectral_radius;     ///< overrides the bound
  bool restore_momentum = true;
  bool fixed_iterations =
      false; ///< no key of the scene file: every step takes `iterations`, whatever its residual
};

struct ContactSettings {
  bool bodies = true;    ///< between particles of different bodies
  bool self = false;     ///< between particles of one body that are not bonded
  double distance = 0.9; ///< in spacings
  double friction = 0.3; ///< Coulomb coefficient between particles
};

/// Of materials whose model is "fluid".
struct FluidSettings {
  double horizon = 2.1;                   ///< reach of the smoothing functions, spacings
  unsigned density_iterations = 5;        ///< a step
  unsigned redistribution_iterations = 5; ///< a step
  /// "fickian", "newton", "printed" or "negated"; see fluid_redistribute.decl.
  std::string redistribution_form = "fickian";
  std::string viscosity_form = "laplacian"; ///< or "central"; see fluid_viscosity_begin.decl
  unsigned viscosity_iterations = 100;      ///< a cap
  double viscosity_tolerance = 1e-3;        ///< relative residual
  std::optional<unsigned> neighbours;       ///< that the list of a particle has room for
};

/// Where fluids may be: what leaves it is removed, or comes in again on the other side where it is periodic.
struct DomainSettings {
  bool given = false;
  Vector3 low = Vector3::Zero(), high = Vector3::Zero(); ///< m
  std::array<bool, 3> periodic = {false, false, false};
};

struct OutputSettings {
  double fps = 30;
  std::vector<std::string> fields; ///< "velocity", "displacement", "strain", "energy", "damage",
                                   ///< "plastic_strain"
  bool data = true;                ///< run.vtkhdf and run.xmf
  unsigned checkpoint_every = 10;  ///< frames; 0: only at the end and when interrupted
};

struct Camera {
  Vector3 eye = Vector3::Zero(), look = Vector3::Zero();
  Vector3 up = {0, 1, 0};
  double fov = 40; ///< degrees, vertical
};

struct RenderSettings {
  bool given = false; ///< a [render] table is present
  std::array<unsigned, 2> size = {1280, 720};
  std::optional<Camera> camera;               ///< else it frames the scene
  std::string show = "surface";               ///< "surface" (skinned mesh where there is one) or "particles"
  std::string color = "body";                 ///< "body" or a field
  std::optional<std::array<double, 2>> range; ///< of the field
  bool ground = true;
  unsigned samples = 4; ///< anti-aliasing
};

struct Scene {
  int format = 1;
  std::string name;
  std::string description;
  std::filesystem::path file; ///< as given; meshes are sought beside it
  SimulationSettings simulation;
  SolverSettings solver;
  ContactSettings contact;
  FluidSettings fluid;
  DomainSettings domain;
  std::vector<Material> materials;
  std::vector<Body> bodies;
  std::vector<Boundary> boundaries;
  std::vector<Emitter> emitters;
  std::vector<Sink> sinks;
  OutputSettings output;
  RenderSettings render;
  bool allow_overlap = false, allow_sparse = false;

  /// Of fluids; they and elastic bodies do not share a scene.
  bool flows() const {
    if (!emitters.empty()) return true;
    for (const Body& body : bodies)
      if (const Material* m = material(body.material); m && m->fluid()) return true;
    return false;
  }
  const Material* material(const std::string& wanted) const {
    for (const Material& m : materials)
      if (m.name == wanted) return &m;
    return nullptr;
  }
};

} // namespace pliant
