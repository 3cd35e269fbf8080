// A particle deep inside a lattice under deformations that are the same everywhere: the engine's kernels let
// it flow, and its stress is summed here from its bonds and their rest lengths.
#pragma once

#include "engine/model/plasticity.h"
#include "engine/solver/plasticity.h"
#include "tests/support/solve_rig.h"

namespace pliant::test {

inline Material plastic_material(double young, double poisson, double cohesion, double friction_degrees,
                                 double hardening = 0) {
  Material made = material_of("ordinary", young, poisson);
  made.plastic.given = true;
  made.plastic.cohesion = cohesion;
  made.plastic.friction = friction_degrees * std::acos(-1.0) / 180;
  made.plastic.hardening = hardening;
  return made;
}

/// A, B and the strengths that follow, in the form of the paper's Eqs. 14 and 15; Pa, tension positive.
struct Cone {
  double a = 0, b = 0;
  explicit Cone(const Material& material) {
    const double s = std::sin(material.plastic.friction), c = std::cos(material.plastic.friction);
    a = 6 * material.plastic.cohesion * c / (std::sqrt(3.) * (3 + s));
    b = 2 * s / (std::sqrt(3.) * (3 + s));
  }
  double tension() const { return a / (1 / std::sqrt(3.) + b); }
  double compression() const { return a / (1 / std::sqrt(3.) - b); }
};

inline double root_j2(const Matrix3& stress) {
  const Matrix3 deviator = stress - stress.trace() / 3 * Matrix3::Identity();
  return std::sqrt(deviator.cwiseProduct(deviator).sum() / 2);
}

class MaterialPoint {
public:
  struct State {
    std::vector<double> rest;
    std::vector<Real4<double>> flow;
  };

  MaterialPoint(Device& device, const Material& material)
      : stage_(make_stage(material)), device_(device), rig_(device, stage_.scene, stage_.model),
        flow_(device, stage_.scene, stage_.model, rig_.plan, rig_.state(),
              stage_.model.spacing / reference_grid) {
    for (const Vector3& x : stage_.model.position) centre_ += x / static_cast<double>(stage_.model.count());
    for (std::uint32_t i = 0; i < stage_.model.count(); ++i)
      if ((stage_.model.position[i] - centre_).norm() < (stage_.model.position[at_] - centre_).norm())
        at_ = i;
  }

  /// Lets everything flow at y = F x.
  void flow(const Matrix3& f) {
    std::vector<Real4<double>> u;
    for (const Vector3& x : stage_.model.position) {
      const Vector3 d = (f - Matrix3::Identity()) * (x - centre_);
      u.push_back({d.x(), d.y(), d.z(), 0});
    }
    device_.upload(rig_.state().best_iterate, u);
    flow_.flow();
  }
  State save() {
    return {device_.download_real(rig_.state().rest), device_.download_real4(rig_.state().flow)};
  }
  void load(const State& state) {
    device_.upload(rig_.state().rest, state.rest);
    device_.upload(rig_.state().flow, state.flow);
  }
  /// x: equivalent plastic strain, y: J taken, z: m3 gained, w: whether it flowed.
  Real4<double> flowed() { return device_.download_real4(rig_.state().flow)[2 * std::size_t{at_}]; }

  /// Cauchy's: of the derivative of the particle's own energy by F, the rest lengths fixed.
  Matrix3 stress(const Matrix3& f) {
    const std::vector<double> rest = device_.download_real(rig_.state().rest);
    const SlicedBonds bonds = slice_bonds(stage_.model);
    const LawConstants& constants = stage_.model.constants[0];
    const double volume = stage_.model.volume[at_];
    const std::uint32_t slice = at_ / slice_width, lane = at_ % slice_width;
    struct Bond {
      Vector3 xi;
      double weight, x, y;
    };
    std::vector<Bond> all;
    double isotropic = 0;
    for (std::uint32_t k = bonds.slice_begin[slice] + lane; k < bonds.slice_begin[slice + 1];
         k += slice_width) {
      if (bonds.neighbour[k] == at_) continue;
      const Vector3 xi = stage_.model.reference[bonds.neighbour[k]] - stage_.model.reference[at_];
      const double p = rest[k / slice_width * 2 * slice_width + lane], x = xi.norm() * p;
      all.push_back({xi, bonds.weight_out[k] / (p * p), x, (f * xi).norm()});
      isotropic += all.back().weight * x * (all.back().y - x) / (constants.modulus * volume);
    }
    Matrix3 first = Matrix3::Zero(); // Piola and Kirchhoff's
    for (const Bond& b : all)
      first += b.weight * (b.y - b.x + b.x * constants.coupling * isotropic) / volume * (f * b.xi / b.y) *
               b.xi.transpose();
    return first * f.transpose() / determinant(f);
  }

  /// Stretches along x by 1 + strain, sides free: from `before` (loaded first), the flow and the side strain
  /// that leaves no stress across. Returns the stress along x.
  double pull(const State& before, double strain, double& side) {
    Matrix3 f = Matrix3::Identity();
    const auto across = [&](double lateral) {
      load(before);
      f = Vector3(1 + strain, 1 + lateral, 1 + lateral).asDiagonal();
      flow(f);
      const Matrix3 sigma = stress(f);
      return (sigma(1, 1) + sigma(2, 2)) / 2;
    };
    double a = side, b = side - 0.1 * strain;
    double at_a = across(a), at_b = across(b);
    for (int k = 0; k < 12 && at_b != at_a && std::abs(b - a) > 1e-12; ++k) {
      const double next = b - at_b * (b - a) / (at_b - at_a);
      a = b, at_a = at_b;
      b = next, at_b = across(b);
      if (std::abs(at_b) < 1e-5 * std::abs(stress(f)(0, 0))) break;
    }
    side = b;
    return stress(f)(0, 0);
  }

private:
  static Stage make_stage(const Material& material) {
    constexpr double spacing = 0.125; // exact in float
    Stage stage(lattice(5, 5, 5, spacing), spacing, material, 0.01);
    stage.scene.solver.method = "newton";
    stage.scene.solver.preconditioner = "diagonal";
    return stage;
  }

  Stage stage_;
  Device& device_;
  SolveRig rig_;
  PlasticFlow flow_;
  Vector3 centre_ = Vector3::Zero();
  std::uint32_t at_ = 0;
};

} // namespace pliant::test
