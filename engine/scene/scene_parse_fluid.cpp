// The rules of fluids: their materials, the bodies that they fill, their domain.
#include "engine/scene/scene_parse_findings.h"

#include <fmt/format.h>

#include <algorithm>

namespace pliant {
namespace {

using Kind = TomlValue::Kind;

constexpr const char* elastic_keys[] = {
    "law",     "form",  "basis",     "calibration",     "anisotropy",       "young",
    "poisson", "split", "inversion", "fracture_energy", "critical_stretch", "plastic"};
/// Of those, what bonds between neighbours of now have too.
constexpr const char* bond_keys[] = {"young", "poisson", "plastic"};
constexpr const char* fluid_keys[] = {"viscosity", "redistribution", "surface_tension", "tensile_strength"};
/// Of bodies: what only bonds can do.
constexpr const char* solid_keys[] = {"fixed",  "moved", "loaded",    "cut",     "deformed",
                                      "deform", "start", "thickness", "horizon", "self_contact"};

/// An element of the list `name`, or null.
const TomlValue* element(const TomlValue& document, const char* name, std::size_t i) {
  const TomlValue* list = document.find(name);
  return list && list->kind == Kind::array && i < list->items.size() && list->items[i].kind == Kind::table
             ? &list->items[i]
             : nullptr;
}

bool is_fluid(const Scene& scene, const std::string& name) {
  const Material* const material = scene.material(name);
  return material && material->fluid();
}

void check_domain(const TomlValue& document, const Scene& scene, Findings& findings) {
  const TomlValue* typed = document.find("domain");
  if (!typed || typed->kind != Kind::table) return;
  if (!scene.flows()) {
    findings.add(typed->where, "domain: only fluids have one; the scene has none");
    return;
  }
  const TomlValue* high = typed->find("high");
  if (!high || !typed->find("low")) return;
  for (int a = 0; a < 3; ++a) {
    if (scene.simulation.dimension == 2 && a == 2) continue;
    if (!(scene.domain.high[a] > scene.domain.low[a]))
      findings.add(high->where, fmt::format("domain.high[{}] = {} must be above domain.low[{}] = {}", a,
                                            scene.domain.high[a], a, scene.domain.low[a]));
    else if (const double cells = (scene.domain.high[a] - scene.domain.low[a]) /
                                  (scene.fluid.horizon * scene.simulation.spacing);
             scene.domain.periodic[static_cast<std::size_t>(a)] && scene.simulation.spacing > 0 &&
             cells < 3.01)
      findings.add(
          high->where,
          fmt::format("domain repeats along {} after {:.4g} m, which must be three times the reach of the "
                      "fluid or more ({:.4g} m): widen it, or take a smaller spacing",
                      "xyz"[a], scene.domain.high[a] - scene.domain.low[a],
                      3.01 * scene.fluid.horizon * scene.simulation.spacing));
  }
  if (scene.simulation.dimension == 2 && scene.domain.periodic[2])
    findings.add(typed->find("periodic")->where,
                 "domain.periodic[2] with dimension = 2: everything stays in the plane z = 0");
}

void check_settings(const TomlValue& document, const Scene& scene, Findings& findings) {
  if (const TomlValue* typed = document.find("fluid"); typed && !scene.flows())
    findings.add(typed->where, "fluid: the scene has no body of a material with model = \"fluid\" or "
                               "\"viscoelastic\", and no emitter");
  if (!scene.flows()) return;
  if (scene.solver.integrator != "implicit-euler")
    findings.add(
        document.find("solver")->find("integrator")->where,
        fmt::format("solver.integrator = \"{}\" is one of elastic bodies; fluids have none to choose",
                    scene.solver.integrator));
  const bool strains = std::any_of(scene.materials.begin(), scene.materials.end(),
                                   [](const Material& m) { return m.bonded() && m.plastic.given; });
  const TomlValue* render = document.find("render");
  const std::string& color = scene.render.color;
  if (render && color != "body" && color != "velocity" && color != "displacement" &&
      !(strains && color == "plastic_strain"))
    findings.add(
        render->find("color")->where,
        fmt::format("render.color = \"{}\": fluids have no such field; choose \"body\", \"velocity\" or "
                    "\"displacement\"",
                    color));
  const TomlValue* output = document.find("output");
  for (const std::string& field : scene.output.fields)
    if (output && field != "velocity" && field != "displacement" && !(strains && field == "plastic_strain"))
      findings.add(output->find("fields")->where,
                   fmt::format("output.fields: fluids have no \"{}\"; they have \"velocity\" and "
                               "\"displacement\"",
                               field));
}

void check_bonded(const TomlValue& value, Material& material, const std::string& path, Findings& findings) {
  check_plastic(value, material, path, findings);
  if (const TomlValue* entry = value.find("poisson"); entry && material.poisson > 0.499)
    findings.add(entry->where,
                 fmt::format("{}.poisson = {} must be at most 0.499: at 0.5 the bulk modulus is "
                             "infinite; the density constraint keeps the volume anyway",
                             path, material.poisson));
}

} // namespace

void check_fluid(const TomlValue& value, Material& material, const std::string& path, Findings& findings) {
  if (material.fluid()) {
    for (const char* key : elastic_keys)
      if (const TomlValue* entry = value.find(key);
          entry && !(material.bonded() &&
                     std::any_of(std::begin(bond_keys), std::end(bond_keys),
                                 [key](const char* bond) { return std::string_view(bond) == key; })))
        findings.add(entry->key_where,
                     fmt::format("{}.{} is one of elastic materials; model = \"{}\" has density, viscosity, "
                                 "redistribution, surface_tension, tensile_strength{} and color",
                                 path, key, material.model,
                                 material.bonded() ? ", young, poisson, plastic, relaxation_time" : ""));
    if (material.bonded())
      check_bonded(value, material, path, findings);
    else if (const TomlValue* entry = value.find("relaxation_time"))
      findings.add(entry->key_where, fmt::format("{}.relaxation_time applies to model = \"viscoelastic\" "
                                                 "only: a fluid bears no shear that could relax",
                                                 path));
    return;
  }
  if (const TomlValue* entry = value.find("relaxation_time"))
    findings.add(entry->key_where,
                 fmt::format("{}.relaxation_time applies to model = \"viscoelastic\" only; this model is "
                             "\"{}\"",
                             path, material.model));
  for (const char* key : fluid_keys)
    if (const TomlValue* entry = value.find(key))
      findings.add(
          entry->key_where,
          fmt::format("{}.{} applies to models \"fluid\" and \"viscoelastic\" only; this model is \"{}\"",
                      path, key, material.model));
}

void check_fluids(const TomlValue& document, const Scene& scene, Findings& findings) {
  check_domain(document, scene, findings);
  check_settings(document, scene, findings);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const TomlValue* table = element(document, "body", b);
    if (!table || !scene.material(body.material)) continue;
    const bool fluid = is_fluid(scene, body.material);
    const TomlValue* typed = table->find("material");
    const TomlValue& where = typed ? *typed : *table;
    for (const MaterialRegion& region : body.regions)
      if (scene.material(region.material) && is_fluid(scene, region.material) != fluid)
        findings.add(where.where,
                     fmt::format("body.{}: '{}' is a fluid and '{}' is not; a body is one or the "
                                 "other: make two of it",
                                 b, fluid ? body.material : region.material,
                                 fluid ? region.material : body.material));
    if (!fluid) {
      if (scene.flows())
        findings.add(where.where,
                     fmt::format("body.{} is elastic and another is a fluid: a scene holds one or the other; "
                                 "obstacles ([[boundary]]) go with both",
                                 b));
      continue;
    }
    for (const char* key : solid_keys)
      if (const TomlValue* entry = table->find(key))
        findings.add(entry->key_where,
                     fmt::format("body.{}.{} is for solids: a fluid's particles hold to nothing", b, key));
    if (body.shape.kind == Shape::Kind::sheet && scene.simulation.dimension == 3)
      findings.add(table->find("shape")->where,
                   fmt::format("body.{}.shape: a fluid fills a shape, and a sheet encloses nothing", b));
  }
}

} // namespace pliant
