// The rules of materials that flow.
#include "engine/scene/scene_parse_findings.h"

#include <fmt/format.h>

#include <algorithm>

namespace pliant {

void check_plastic(const TomlValue& value, Material& material, const std::string& path, Findings& findings) {
  const TomlValue* const plastic = value.find("plastic");
  if (!plastic) return;
  material.plastic.given = true;
  const TomlValue* const law = value.find("law");
  if (!law)
    material.law = "ordinary";
  else if (material.law != "ordinary")
    findings.add(
        law->where,
        fmt::format("{}.law = \"{}\" does not flow: plasticity changes lengths of bonds, which law = "
                    "\"ordinary\" is made of; type that, or leave law or plastic out",
                    path, material.law));
  for (const char* key : {"fracture_energy", "critical_stretch"})
    if (const TomlValue* breaks = value.find(key))
      findings.add(
          breaks->key_where,
          fmt::format("{}.{}: a material cannot both flow and break; leave this or plastic out", path, key));
  const TomlValue* const cohesion =
      plastic->kind == TomlValue::Kind::table ? plastic->find("cohesion") : nullptr;
  if (cohesion && cohesion->is_number() && cohesion->number == 0 && material.plastic.friction == 0)
    findings.add(cohesion->where,
                 fmt::format("{}.plastic.cohesion = 0 without friction bears nothing: give a cohesion above "
                             "0 Pa or a friction above 0 degrees",
                             path));
}

void check_plastic_bodies(const TomlValue& document, const Scene& scene, Findings& findings) {
  const TomlValue* const bodies = document.find("body");
  if (!bodies || bodies->kind != TomlValue::Kind::array) return;
  const auto flows = [&](const std::string& name) {
    const Material* const material = scene.material(name);
    return material && material->plastic.given;
  };
  const bool stress = scene.simulation.dimension == 2 && scene.simulation.plane == "stress";
  for (std::size_t b = 0; b < scene.bodies.size() && b < bodies->items.size(); ++b) {
    const Body& body = scene.bodies[b];
    const bool sheet = scene.simulation.dimension == 3 && body.thickness;
    if (!stress && !sheet) continue;
    if (!flows(body.material) && std::none_of(body.regions.begin(), body.regions.end(),
                                              [&](const auto& region) { return flows(region.material); }))
      continue;
    const TomlValue* const typed = bodies->items[b].find("material");
    findings.add(typed ? typed->where : bodies->items[b].where,
                 fmt::format("body.{}: a material with plastic fills solids and plane strain only; in {} "
                             "what yields depends on the strain across, which is not known",
                             b, sheet ? "a sheet" : "plane stress"));
  }
}

} // namespace pliant
