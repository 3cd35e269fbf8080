// Yield surfaces from cohesion and friction.
#include "engine/model/plasticity.h"

#include "engine/core/error.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace pliant {

YieldSurface yield_surface(const Material& material, Neighbourhood neighbourhood) {
  const Plasticity& plastic = material.plastic;
  const auto refuse = [&](const std::string& what) {
    throw Error(ExitCode::usage, fmt::format("material '{}': {}", material.name, what));
  };
  if (!(plastic.friction >= 0 && plastic.friction < std::numbers::pi / 2))
    refuse(fmt::format("the angle of internal friction lies from 0 to below 90 degrees, not at {}",
                       plastic.friction * 180 / std::numbers::pi));
  if (!(plastic.cohesion >= 0) || !(plastic.hardening >= 0))
    refuse(fmt::format("cohesion and hardening are 0 or more, not {} and {} Pa", plastic.cohesion,
                       plastic.hardening));
  if (plastic.cohesion == 0 && plastic.friction == 0)
    refuse("without cohesion and without friction nothing is borne; give a cohesion in Pa");
  if (neighbourhood == Neighbourhood::plane_stress)
    refuse("sheets and plane stress do not flow: what yields depends on the strain across, which they do "
           "not know; take a solid or plane strain");
  const double shear = material.young / (2 * (1 + material.poisson));
  const double lame =
      material.young * material.poisson / ((1 + material.poisson) * (1 - 2 * material.poisson));
  const double sine = std::sin(plastic.friction), cosine = std::cos(plastic.friction);
  YieldSurface surface;
  double of_cohesion = cosine;
  if (neighbourhood == Neighbourhood::plane_strain) {
    surface.shear = std::sqrt(8.) * shear;
    surface.pressure = 2 * (lame + shear) * sine;
    surface.equivalent = std::sqrt(8. / 3);
  } else {
    const double cone = std::sqrt(3.) * (3 + sine);
    of_cohesion = 6 * cosine / cone;
    surface.shear = std::sqrt(15.) * shear;
    surface.pressure = 9 * (lame + 2 * shear / 3) * (2 * sine / cone);
    surface.equivalent = std::sqrt(5.);
  }
  surface.strength = of_cohesion * plastic.cohesion;
  surface.hardening = of_cohesion * plastic.hardening;
  return surface;
}

bool can_flow(const Scene& scene, const Model& model) {
  for (std::size_t i = 0; i < model.count(); ++i)
    if (typed_material(scene, model, i).plastic.given) return true;
  return false;
}

std::vector<YieldSurface> yield_surfaces(const Scene& scene, const Model& model) {
  for (const Material& material : scene.materials) {
    if (!material.plastic.given || material.fluid()) continue;
    if (material.law != "ordinary")
      throw Error(ExitCode::usage,
                  fmt::format("{}: material '{}' of law \"{}\" cannot flow: plasticity changes lengths of "
                              "bonds, which law \"ordinary\" is made of; choose that",
                              scene.file.string(), material.name, material.law));
    if (material.breaks())
      throw Error(ExitCode::usage,
                  fmt::format("{}: material '{}' cannot both flow and break: leave out plastic, or its "
                              "fracture_energy and critical_stretch",
                              scene.file.string(), material.name));
  }
  YieldSurface elastic;
  elastic.strength = std::numeric_limits<double>::infinity();
  std::vector<YieldSurface> surfaces(model.count(), elastic);
  for (const BodyModel& body : model.bodies) {
    const Neighbourhood neighbourhood = body.thickness == 0 ? Neighbourhood::solid
                                        : model.dimension == 3 || scene.simulation.plane == "stress"
                                            ? Neighbourhood::plane_stress
                                            : Neighbourhood::plane_strain;
    const Material* last = nullptr;
    YieldSurface surface;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      const Material& material = typed_material(scene, model, i);
      if (!material.plastic.given) continue;
      if (&material != last) surface = yield_surface(material, neighbourhood);
      last = &material;
      surfaces[i] = surface;
    }
  }
  return surfaces;
}

} // namespace pliant
