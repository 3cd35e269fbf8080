// The stretch that a material bears, from the energy that a crack takes.
#include "engine/model/failure.h"

#include "engine/core/error.h"
#include "engine/model/separation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

namespace pliant {

std::vector<Vector3> crack_normals(const Model& model, std::uint32_t particle) {
  if (!(model.bodies[model.body[particle]].thickness > 0))
    return {Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};
  Vector3 along = Vector3::Zero();
  Matrix3 spread = Matrix3::Zero();
  for (std::uint32_t b = model.bonds.begin[particle]; b < model.bonds.begin[particle + 1]; ++b) {
    const Vector3 xi = model.reference[model.bonds.neighbour[b]] - model.reference[particle];
    spread += xi * xi.transpose();
    if (along.norm() == 0 || xi.norm() < along.norm()) along = xi;
  }
  const Vector3 off_plane = Eigen::SelfAdjointEigenSolver<Matrix3>(spread).eigenvectors().col(0);
  along = (along - off_plane * off_plane.dot(along)).normalized();
  return {along, off_plane.cross(along)};
}

bool can_break(const Scene& scene, const Model& model) {
  for (std::size_t i = 0; i < model.count(); ++i)
    if (typed_material(scene, model, i).breaks()) return true;
  return false;
}

std::vector<double> critical_stretches(const Scene& scene, const Model& model) {
  for (const Material& material : scene.materials)
    if (material.breaks() && !may_break(material))
      throw Error(
          ExitCode::usage,
          fmt::format("{}: material '{}': bonds of law \"{}\" do not break, because its shape tensors do "
                      "not know of broken ones; take law \"corotated\", \"ordinary\", \"basis\" or "
                      "\"stvk\", or leave its fracture_energy and critical_stretch out",
                      scene.file.string(), material.name, material.law));
  std::vector<double> stretch(model.count(), std::numeric_limits<double>::infinity());
  const Bonds& bonds = model.bonds;
  for (const BodyModel& body : model.bodies) {
    std::uint32_t fullest = body.first;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
      if (bonds.begin[i + 1] - bonds.begin[i] > bonds.begin[fullest + 1] - bonds.begin[fullest]) fullest = i;
    BondSet set;
    for (std::uint32_t b = bonds.begin[fullest]; b < bonds.begin[fullest + 1]; ++b) {
      set.bond.emplace_back(model.reference[bonds.neighbour[b]] - model.reference[fullest]);
      set.weight.push_back(bonds.weight[b]);
      if (!bonds.strength.empty()) set.strength.push_back(bonds.strength[b]);
    }
    std::map<std::uint32_t, double> found; // by the model's material
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      const Material& material = typed_material(scene, model, i);
      if (material.critical_stretch) stretch[i] = *material.critical_stretch;
      if (!material.fracture_energy || set.bond.empty()) continue;
      const std::uint32_t m = model.material[i];
      const auto [at, unknown] = found.try_emplace(m, 0.0);
      if (unknown)
        at->second = Separation(law_of(material), model.constants[m], model.stretch[m], set)
                         .critical_stretch(*material.fracture_energy, crack_normals(model, fullest));
      stretch[i] = at->second;
    }
  }
  return stretch;
}

bool box_meets(const Shape& box, const Vector3& a, const Vector3& b) {
  if (box.kind != Shape::Kind::box)
    throw Error(ExitCode::usage, "a cut is a box: region = { box = [length, width, thickness], at = [...] }");
  const Eigen::AngleAxisd turn(-box.rotate_degrees * std::numbers::pi / 180, box.rotate_axis);
  const Vector3 from = turn * (a - box.at), along = turn * (b - a);
  double enters = 0, leaves = 1;
  for (int k = 0; k < 3; ++k) {
    const double half = box.size[k] / 2;
    if (along[k] == 0) {
      if (std::abs(from[k]) > half) return false;
      continue;
    }
    const double one = (-half - from[k]) / along[k], other = (half - from[k]) / along[k];
    enters = std::max(enters, std::min(one, other));
    leaves = std::min(leaves, std::max(one, other));
  }
  return enters <= leaves;
}

} // namespace pliant
