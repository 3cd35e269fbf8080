// A model of one body from a list of points.
#include "engine/core/error.h"
#include "engine/model/anisotropy.h"
#include "engine/model/arrange.h"

#include <fmt/core.h>

#include <cmath>

namespace pliant {

namespace {

/// The point nearest to the centroid: the body's origin, so that a lattice stays on its own grid.
Vector3 central_point(const std::vector<Vector3>& points) {
  Vector3 centroid = Vector3::Zero();
  for (const Vector3& p : points) centroid += p / static_cast<double>(points.size());
  const Vector3* nearest = nullptr;
  for (const Vector3& p : points)
    if (!nearest || (p - centroid).squaredNorm() < (*nearest - centroid).squaredNorm()) nearest = &p;
  return nearest ? *nearest : Vector3::Zero();
}

} // namespace

Model assemble_points(const std::vector<Vector3>& points, double spacing, double horizon_in_spacings,
                      const Material& material, double volume_each, const std::string& weights,
                      double weight_exponent) {
  if (!(volume_each > 0) || !std::isfinite(volume_each))
    throw Error(ExitCode::usage, fmt::format("a particle's volume must be positive, not {} m3", volume_each));
  if (!(material.density > 0) || !std::isfinite(material.density))
    throw Error(ExitCode::usage, fmt::format("the density must be positive, not {} kg/m3", material.density));
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw Error(ExitCode::usage, fmt::format("the position of particle {} is not finite ({}, {}, {})", i,
                                               points[i].x(), points[i].y(), points[i].z()));
  const Law law = law_of(material);
  Model model;
  model.spacing = spacing;
  model.horizon = horizon_in_spacings * spacing;
  model.constants.push_back(law_constants(material));
  model.stretch.push_back(stretch_energy(material));
  BodyModel body;
  body.name = "points";
  body.origin = central_point(points);
  body.color = material.color;

  std::vector<Vector3> relative(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) relative[i] = points[i] - body.origin;
  BodyParticles particles;
  Arrangement& part = particles.arrangement;
  if (law == Law::fluid) {
    part = arrange_unbonded(relative, spacing);
  } else {
    part = arrange(relative, spacing, model.horizon);
    model.weight_report = compute_weights(part.bonds, part.reference, spacing, law, weights, weight_exponent);
  }
  particles.position.reserve(points.size());
  for (const Vector3& r : part.reference) particles.position.push_back(body.origin + r);
  particles.velocity.assign(points.size(), Vector3::Zero());
  particles.volume.assign(points.size(), volume_each);
  particles.mass.assign(points.size(), material.density * volume_each);
  particles.material.assign(points.size(), 0);
  model.bodies.push_back(std::move(body));
  append(model, 0, law, std::move(particles));
  Scene scene;
  scene.materials = {material};
  model.bonds.strength = bond_strengths(scene, model);
  return model;
}

} // namespace pliant
