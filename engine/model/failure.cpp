// The stretch that a material bears, from the energy that a crack takes.
#include "engine/model/failure.h"

#include "engine/core/error.h"
#include "engine/model/lame.h"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace pliant {

double critical_stretch(double fracture_energy, double young, double poisson, double reach,
                        Neighbourhood neighbourhood) {
  const auto [shear, lame] = lame_constants(young, poisson, neighbourhood);
  double modulus = 0, factor = 1;
  if (neighbourhood != Neighbourhood::solid) {
    const double bulk = lame + shear;
    modulus = 4 * shear;
    factor +=
        16 / (9 * std::numbers::pi * std::numbers::pi) * (bulk - 2 * shear) / (6 / std::numbers::pi * shear);
  } else {
    const double bulk = lame + 2. / 3 * shear;
    modulus = 7.5 * shear;
    factor += 81. / 256 * (bulk - 5. / 3 * shear) / (3 * shear);
  }
  return std::sqrt(fracture_energy / (factor * modulus * reach));
}

double crack_reach(const Model& model, std::uint32_t particle) {
  if (model.bodies[model.body[particle]].thickness > 0) { // any normal in its plane
    double length = 0;
    for (std::uint32_t b = model.bonds.begin[particle]; b < model.bonds.begin[particle + 1]; ++b)
      length += model.bonds.weight[b] *
                (model.reference[model.bonds.neighbour[b]] - model.reference[particle]).norm();
    return 2 / std::numbers::pi * length;
  }
  std::vector<Vector3> normals;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x != 0 || y != 0 || z != 0) normals.push_back(Vector3(x, y, z).normalized());
  double reach = 0;
  for (std::uint32_t b = model.bonds.begin[particle]; b < model.bonds.begin[particle + 1]; ++b) {
    const Vector3 xi = model.reference[model.bonds.neighbour[b]] - model.reference[particle];
    double sum = 0;
    for (const Vector3& n : normals) sum += std::abs(xi.dot(n));
    reach += model.bonds.weight[b] * sum / static_cast<double>(normals.size());
  }
  return reach;
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
    const double reach = body.count > 0 ? crack_reach(model, fullest) : 0;
    const Neighbourhood neighbourhood = body.thickness == 0 ? Neighbourhood::solid
                                        : model.dimension == 3 || scene.simulation.plane == "stress"
                                            ? Neighbourhood::plane_stress
                                            : Neighbourhood::plane_strain;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      const Material& material = typed_material(scene, model, i);
      if (material.critical_stretch) stretch[i] = *material.critical_stretch;
      if (material.fracture_energy && reach > 0)
        stretch[i] = critical_stretch(*material.fracture_energy, material.young, material.poisson, reach,
                                      neighbourhood);
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
