// Small bodies of materials that break, and states in which many of their bonds have.
#pragma once

#include "tests/support/bodies.h"
#include "tests/support/solve_rig.h"

namespace pliant::test {

inline constexpr double critical = 0.2; ///< stretch less one at which the bonds of these bodies break

struct Breakable {
  std::string name;
  Material material;
};

/// Each law over bonds, in each of its forms.
inline std::vector<Breakable> breakable_materials(double poisson = 0.3) {
  std::vector<Breakable> made;
  const auto add = [&](const std::string& name, const std::string& law, const std::string& form = "") {
    Material material = material_of(law, 1e5, poisson);
    material.form = form;
    material.critical_stretch = critical;
    made.push_back({name, material});
    return &made.back().material;
  };
  add("corotated", "corotated");
  add("ordinary", "ordinary");
  Material* basis = add("basis", "basis");
  basis->volume_basis = {{"B1", 1.0}};
  basis->bond_basis = {{"A2", 0.5}, {"B1", 0.5}};
  Material* directed = add("basis with directions", "basis");
  directed->volume_basis = directed->bond_basis = {{"B1", 1.0}};
  directed->anisotropy.given = true;
  directed->anisotropy.strengths = {2, 0.5, 1};
  add("stvk", "stvk", "exact");
  add("stvk of bonds", "stvk", "bonds");
  add("neo-hookean of bonds", "neo-hookean", "bonds");
  return made;
}

/// Without inertia, so that products are the derivative of the force alone.
inline Stage breakable_stage(const Material& material, double spacing, const char* method = "newton") {
  Stage stage(lattice(5, 4, 4, spacing), spacing, material, 1. / 60);
  stage.scene.solver.method = method;
  stage.scene.solver.preconditioner = "diagonal";
  stage.model.mass.assign(stage.model.count(), 1e-30);
  return stage;
}

/// Forces whose polar decompositions start from no rotation, not from those of the call before.
inline std::vector<Vector3> forces_anew(Device& device, SolveRig& rig, const std::vector<Vector3>& u) {
  if (rig.state().rotation)
    device.upload(rig.state().rotation, std::vector<Real4<double>>(u.size(), Real4<double>{0, 0, 0, 1}));
  return rig.forces(u);
}

/// Exact in float, with noise of so many spacings.
inline std::vector<Vector3> noisy(const Model& model, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Vector3> u;
  for (std::size_t i = 0; i < model.count(); ++i)
    u.push_back((noise * model.spacing * random_vector(random)).cast<float>().cast<double>());
  return u;
}

/// The bonds (by the model's number) that displacements `u` break where all are whole.
inline std::vector<bool> broken_by(const Model& model, const std::vector<Vector3>& u) {
  std::vector<bool> broken(model.bonds.count());
  for (std::uint32_t i = 0; i < model.count(); ++i)
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model.bonds.neighbour[b];
      const Vector3 xi = model.reference[j] - model.reference[i];
      broken[b] = (xi + u[j] - u[i]).norm() > (1 + critical) * xi.norm();
    }
  return broken;
}

} // namespace pliant::test
