// The rules of a scene file that join several keys, or several tables.
#include "engine/scene/scene_parse_findings.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant {
namespace {

using Kind = TomlValue::Kind;

constexpr double most_steps = 1e9;
constexpr double most_frames = 1e6;
constexpr std::size_t longest_name = 64; // bytes; names become names of files and of groups in them

/// Eq. 25 needs a potential, and a line search to see it fall. Where no tolerance is typed, nonlinear laws
/// end at 1e-4 of it, as Xu et al. (2018) do.
void check_energy_tolerance(const TomlValue& document, Scene& scene, Findings& findings) {
  const TomlValue* solver = document.find("solver");
  const TomlValue* typed = solver ? solver->find("energy_tolerance") : nullptr;
  SolverSettings& settings = scene.solver;
  if (!typed) {
    const bool nonlinear = std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) {
      return m.law == "basis" || m.law == "stvk" || m.law == "neo-hookean";
    });
    settings.energy_assumed = nonlinear && !(solver && solver->find("tolerance"));
    if (settings.energy_assumed) settings.energy_tolerance = 1e-4;
    return;
  }
  const auto refuse = [&](const std::string& why) {
    findings.add(typed->where, "solver.energy_tolerance: " + why + "; type solver.tolerance instead");
  };
  for (const char* method : {"chebyshev", "jacobi", "position"})
    if (settings.method == method)
      refuse(fmt::format("{} has no line search that sees the energy fall: newton, lbfgs and direct have",
                         method));
  if (std::any_of(scene.materials.begin(), scene.materials.end(),
                  [](const Material& m) { return m.law == "projective"; }))
    refuse("the projective law has no potential whose error could be judged");
  const bool touching = (scene.contact.bodies && scene.bodies.size() > 1) || scene.contact.self;
  if ((touching && scene.contact.friction > 0) ||
      std::any_of(scene.boundaries.begin(), scene.boundaries.end(),
                  [](const Boundary& b) { return b.slip && b.friction > 0; }))
    refuse("slipping with friction has no potential whose error could be judged");
}

void check_shape(const TomlValue& value, Shape& shape, const std::string& path, Findings& findings) {
  static constexpr std::array<std::pair<const char*, Shape::Kind>, 7> kinds = {
      {{"box", Shape::Kind::box},
       {"sphere", Shape::Kind::sphere},
       {"cylinder", Shape::Kind::cylinder},
       {"torus", Shape::Kind::torus},
       {"mesh", Shape::Kind::mesh},
       {"plane", Shape::Kind::plane},
       {"sheet", Shape::Kind::sheet}}};
  std::vector<std::string> typed;
  for (const auto& [name, kind] : kinds)
    if (value.find(name)) {
      typed.emplace_back(name);
      shape.kind = kind;
    }
  if (typed.size() != 1) {
    findings.add(
        value.where,
        fmt::format("{} must have exactly one of box, sphere, cylinder, torus, mesh, plane, sheet; it has {}",
                    path, typed.empty() ? "none" : fmt::format("{}", fmt::join(typed, " and "))));
    return;
  }
  const auto refuse = [&](const char* key, const char* reason) {
    if (const TomlValue* entry = value.find(key))
      findings.add(entry->key_where,
                   fmt::format("{}.{} does not apply to a {}: {}", path, key, typed.front(), reason));
  };
  if (shape.kind != Shape::Kind::mesh) refuse("fit", "it scales a mesh; type the size itself");
  if (shape.kind != Shape::Kind::plane) refuse("offset", "it places a plane; type at = [x, y, z]");
  if (shape.kind == Shape::Kind::plane) {
    refuse("rotate", "give the normal that it should have");
    if (value.find("at")) {
      if (value.find("offset")) refuse("offset", "at has placed it already");
      shape.offset = shape.normal.dot(shape.at);
    }
  }
  if (shape.kind == Shape::Kind::mesh) {
    if (value.find("at")) shape.place = shape.at;
    const TomlValue* mesh = value.find("mesh");
    if (mesh->kind == Kind::text && mesh->text.empty())
      findings.add(mesh->where, fmt::format("{}.mesh is empty; name a file such as \"armadillo.off\"", path));
  }
  if (shape.kind == Shape::Kind::torus && shape.radius > 0 && shape.tube > shape.radius)
    findings.add(
        value.find("torus")->where,
        fmt::format("{}.torus: the tube ({}) must be at most the ring ({}), or the torus would cross itself",
                    path, shape.tube, shape.radius));
}

void check_inversion(const TomlValue& value, Material& material, const std::string& path,
                     Findings& findings) {
  const TomlValue* typed = value.find("inversion");
  const bool projective = material.law == "projective";
  if (projective && !typed) material.inversion = "clamp";
  if (!typed) return;
  if (!may_invert(material))
    findings.add(
        typed->key_where,
        fmt::format("{}.inversion applies to laws over bonds; law = \"{}\" is none and comes back from "
                    "inverted states by itself",
                    path, material.law));
  else if (projective && material.inversion == "none")
    findings.add(typed->where,
                 fmt::format("{}.inversion = \"none\" cannot be had with law = \"projective\", whose targets "
                             "need one: \"clamp\" or \"swap\"",
                             path));
  else if (!projective && material.inversion == "swap")
    findings.add(typed->where, fmt::format("{}.inversion = \"swap\" goes with law = \"projective\" only; "
                                           "this law is \"{}\": \"none\" or \"clamp\"",
                                           path, material.law));
}

void check_failure(const TomlValue& value, const Material& material, const std::string& path,
                   Findings& findings) {
  const TomlValue* const energy = value.find("fracture_energy");
  const TomlValue* const stretch = value.find("critical_stretch");
  if (energy && stretch)
    findings.add(
        stretch->key_where,
        fmt::format("{}.critical_stretch and {}.fracture_energy say the same twice: the stretch follows "
                    "from the energy; keep one",
                    path, path));
  const TomlValue* const typed = energy ? energy : stretch;
  if (!typed) return;
  if (!may_break(material))
    findings.add(
        typed->key_where,
        fmt::format("{}.{}: bonds of law = \"{}\" do not break, because its shape tensors do not know "
                    "of broken ones; choose law = \"corotated\", \"ordinary\", \"basis\" or "
                    "\"stvk\"{}",
                    path, typed->key, material.law,
                    material.law == "neo-hookean" ? ", or form = \"bonds\"" : ""));
  else if (material.inversion == "clamp")
    findings.add(value.find("inversion")->where,
                 fmt::format("{}.inversion = \"clamp\" pushes along shape tensors that do not know of broken "
                             "bonds: leave it out, or {}",
                             path, typed->key));
}

void check_material(const TomlValue& value, Material& material, const std::string& path, Findings& findings) {
  material.color_given = value.find("color") != nullptr;
  check_fluid(value, material, path, findings);
  if (material.fluid()) return;
  check_plastic(value, material, path, findings);
  check_basis_law(value, material, path, findings);
  check_inversion(value, material, path, findings);
  check_failure(value, material, path, findings);
  if (material.law == "projective") return; // its ratio is checked with its bodies
  for (const char* key : {"split"})
    if (const TomlValue* entry = value.find(key))
      findings.add(entry->key_where,
                   fmt::format("{}.{} applies to law = \"projective\" only; this law is \"{}\"", path, key,
                               material.law));
}

void check_times(const TomlValue& value, double start, double end, const std::string& path,
                 Findings& findings) {
  if (const TomlValue* typed = value.find("end"); typed && end <= start)
    findings.add(typed->where, fmt::format("{}.end = {} must be after its start = {}", path, end, start));
}

void check_moved(const TomlValue& value, const Motion& motion, const std::string& path, Findings& findings) {
  check_times(value, motion.start, motion.end, path, findings);
  if (motion.release.value_or(false) && !value.find("end"))
    findings.add(value.find("release")->where,
                 fmt::format("{}.release needs {}.end: particles are released then", path, path));
}

void check_boundary(const TomlValue& value, const Boundary& boundary, const std::string& path,
                    Findings& findings) {
  check_times(value, boundary.motion.start, boundary.motion.end, path, findings);
  if (boundary.motion.release.value_or(false) && !value.find("end"))
    findings.add(value.find("release")->where,
                 fmt::format("{}.release needs {}.end: the obstacle is taken away then", path, path));
  if (const TomlValue* friction = value.find("friction"); friction && !boundary.slip)
    findings.add(
        friction->key_where,
        fmt::format(
            "{}.friction applies where condition = \"slip\" only; \"no-slip\" holds every particle that "
            "touches",
            path));
  if (boundary.inside && boundary.shape.kind == Shape::Kind::plane)
    findings.add(value.find("inside")->where,
                 fmt::format("{}.inside does not apply to a plane: turn its normal round", path));
}

void check_camera(const TomlValue& value, const Camera& camera, const std::string& path, Findings& findings) {
  if (!value.find("eye") || !value.find("look")) return;
  const Vector3 view = camera.look - camera.eye;
  if (!(view.norm() > 0))
    findings.add(value.where,
                 fmt::format("{}: eye and look are the same point; the camera has no direction", path));
  else if (!(view.normalized().cross(camera.up).norm() > 1e-6))
    findings.add(value.where,
                 fmt::format("{}: up is parallel to the view; give another up, such as [1, 0, 0]", path));
}

void check_render(const TomlValue& value, const RenderSettings& render, const std::string& path,
                  Findings& findings) {
  const TomlValue* range = value.find("range");
  if (!range || !render.range) return;
  if ((*render.range)[0] >= (*render.range)[1])
    findings.add(range->where, fmt::format("{}.range must rise: [least, greatest]", path));
  if (render.color == "body")
    findings.add(range->key_where,
                 fmt::format("{}.range needs {}.color to be a field, such as \"strain\"", path, path));
}

void check_name(const Where& where, std::string_view what, const std::string& name, Findings& findings) {
  const bool legible = std::all_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 && c != '/' && c != '\\' && c != 0x7f;
  });
  if (name.empty() || name.size() > longest_name || !legible || name == "." || name == "..")
    findings.add(
        where,
        fmt::format("the name of {} is {}; it must be of 1 to {} letters without slashes, because files "
                    "are named after it",
                    what, in_quotes(name), longest_name));
}

/// Files of results hold each body under its name, and readers of theirs take no others.
bool names_a_group(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !name.empty() && letter(name.front()) && name != "Assembly" &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-'; });
}

/// Names of bodies or boundaries: given where absent, unique, not mistaken for a number.
template <class Things>
void name_things(const TomlValue* list, Things& things, std::string_view what, Findings& findings) {
  std::vector<std::string> taken;
  for (std::size_t i = 0; i < things.size(); ++i) {
    const TomlValue* typed = list->items[i].find("name");
    const Where where = typed ? typed->where : list->items[i].where;
    std::string& name = things[i].name;
    if (!typed || typed->kind != Kind::text) name = fmt::format("{}-{}", what, i);
    check_name(where, fmt::format("this {}", what), name, findings);
    if (!name.empty() && name.find_first_not_of("0123456789") == std::string::npos)
      findings.add(
          where,
          fmt::format("{} {} is named by a number, which stands for its place in the list; add a letter",
                      what, in_quotes(name)));
    else if (what == "body" && !names_a_group(name))
      findings.add(where, fmt::format("body {} cannot be written under its name: it must start with a "
                                      "letter or _, go on with letters, digits, - and _, and not be "
                                      "\"Assembly\"",
                                      in_quotes(name)));
    if (std::find(taken.begin(), taken.end(), name) != taken.end())
      findings.add(where, fmt::format("two {} are named {}; names must differ",
                                      what == "body"       ? "bodies"
                                      : what == "boundary" ? "boundaries"
                                                           : fmt::format("{}s", what),
                                      in_quotes(name)));
    taken.push_back(name);
  }
}

void check_reference(const TomlValue& table, const std::string& path,
                     const std::vector<std::string>& materials, Findings& findings) {
  const TomlValue* typed = table.find("material");
  if (!typed || typed->kind != Kind::text || materials.empty()) return;
  if (std::find(materials.begin(), materials.end(), typed->text) == materials.end())
    findings.add(typed->where, fmt::format("{}.material = {} is not a material of this scene{}", path,
                                           in_quotes(typed->text), suggestion(typed->text, materials)));
}

/// Where the shape of a body or an obstacle was typed, for faults that are found once meshes are read.
std::string place_of_shape(const TomlValue& value) {
  const TomlValue* shape = value.find("shape");
  if (!shape || shape->where.override_index >= 0) return "";
  return fmt::format(":{}:{}", shape->where.line, shape->where.column);
}

} // namespace

void check_table(const schema::Table& table, const TomlValue& value, void* object, const std::string& path,
                 Findings& findings) {
  if (&table == &schema::shape_table()) {
    check_shape(value, *static_cast<Shape*>(object), path, findings);
  } else if (&table == &schema::material_table()) {
    check_material(value, *static_cast<Material*>(object), path, findings);
  } else if (&table == &schema::anisotropy_table()) {
    check_directions(value, *static_cast<Anisotropy*>(object), path, findings);
  } else if (&table == &schema::moved_table()) {
    check_moved(value, static_cast<Condition*>(object)->motion, path, findings);
  } else if (&table == &schema::loaded_table()) {
    const auto& condition = *static_cast<Condition*>(object);
    check_times(value, condition.start, condition.end, path, findings);
  } else if (&table == &schema::boundary_table()) {
    check_boundary(value, *static_cast<Boundary*>(object), path, findings);
    static_cast<Boundary*>(object)->typed_at = place_of_shape(value);
  } else if (&table == &schema::emitter_table()) {
    check_emitter(value, *static_cast<Emitter*>(object), path, findings);
  } else if (&table == &schema::sink_table()) {
    check_sink(value, *static_cast<Sink*>(object), path, findings);
  } else if (&table == &schema::camera_table()) {
    check_camera(value, *static_cast<Camera*>(object), path, findings);
  } else if (&table == &schema::render_table()) {
    check_render(value, *static_cast<RenderSettings*>(object), path, findings);
  } else if (&table == &schema::body_table()) {
    Body& body = *static_cast<Body*>(object);
    body.typed_at = place_of_shape(value);
    if (body.shape.kind == Shape::Kind::plane)
      findings.add(value.find("shape")->where,
                   fmt::format("{}.shape: a plane encloses nothing to fill with particles", path));
  }
}

void check_scene(const TomlValue& document, Scene& scene, Findings& findings) {
  if (const TomlValue* name = document.find("name"); name && name->kind == Kind::text)
    check_name(name->where, "the scene", scene.name, findings);
  else
    scene.name = scene.file.stem().string();

  std::vector<std::string> materials;
  if (const TomlValue* tables = document.find("materials"); tables && tables->kind == Kind::table) {
    for (const TomlValue& table : tables->items) {
      check_name(table.key_where, "this material", table.key, findings);
      materials.push_back(table.key);
    }
    if (materials.empty()) findings.add(tables->where, "the scene has no material; add [materials.rubber]");
  }
  if (const TomlValue* bodies = document.find("body"); bodies && bodies->kind == Kind::array) {
    if (bodies->items.empty()) findings.add(bodies->where, "the scene has no body; add [[body]]");
    name_things(bodies, scene.bodies, "body", findings);
    for (std::size_t i = 0; i < bodies->items.size(); ++i) {
      check_reference(bodies->items[i], fmt::format("body.{}", i), materials, findings);
      const TomlValue* regions = bodies->items[i].find("region");
      for (std::size_t j = 0; regions && regions->kind == Kind::array && j < regions->items.size(); ++j)
        check_reference(regions->items[j], fmt::format("body.{}.region.{}", i, j), materials, findings);
    }
  }
  if (!document.find("body") && !document.find("emitter"))
    findings.add(document.where, "the scene lacks [[body]] (solids and fluids)");
  for (const auto& [what, list] :
       {std::pair{"emitter", document.find("emitter")}, {"sink", document.find("sink")}}) {
    if (!list || list->kind != Kind::array) continue;
    if (std::string_view(what) == "sink") {
      name_things(list, scene.sinks, what, findings);
      continue;
    }
    name_things(list, scene.emitters, what, findings);
    for (std::size_t i = 0; i < list->items.size(); ++i)
      check_reference(list->items[i], fmt::format("emitter.{}", i), materials, findings);
  }
  const bool breaks = std::any_of(scene.materials.begin(), scene.materials.end(),
                                  [](const Material& material) { return material.breaks(); });
  for (const auto& [table, key] : {std::pair{"render", "color"}, {"output", "fields"}}) {
    const TomlValue* owner = document.find(table);
    const TomlValue* typed = owner ? owner->find(key) : nullptr;
    const bool wanted =
        std::string_view(table) == "render"
            ? scene.render.color == "damage"
            : std::count(scene.output.fields.begin(), scene.output.fields.end(), "damage") > 0;
    if (typed && wanted && !breaks)
      findings.add(typed->where,
                   fmt::format("{}.{}: there is no damage where nothing breaks; give a material a "
                               "fracture_energy or a critical_stretch",
                               table, key));
  }
  if (const TomlValue* boundaries = document.find("boundary"); boundaries && boundaries->kind == Kind::array)
    name_things(boundaries, scene.boundaries, "boundary", findings);

  const bool flows = std::any_of(scene.materials.begin(), scene.materials.end(),
                                 [](const Material& material) { return material.plastic.given; });
  for (const auto& [table, key] : {std::pair{"render", "color"}, {"output", "fields"}}) {
    const TomlValue* owner = document.find(table);
    const TomlValue* typed = owner ? owner->find(key) : nullptr;
    const std::vector<std::string>& fields = scene.output.fields;
    const bool wanted = std::string_view(table) == "render"
                            ? scene.render.color == "plastic_strain"
                            : std::count(fields.begin(), fields.end(), "plastic_strain") > 0;
    if (typed && wanted && !flows)
      findings.add(typed->where,
                   fmt::format("{}.{}: there is no plastic strain where nothing flows; give a material "
                               "plastic = {{ cohesion = ... }}",
                               table, key));
  }
  if (flows) check_plastic_bodies(document, scene, findings);

  check_fluids(document, scene, findings);
  check_flow(document, scene, findings);
  check_flat(document, scene, findings);
  check_energy_tolerance(document, scene, findings);

  const TomlValue* simulation = document.find("simulation");
  if (!simulation) return;
  const double steps = scene.simulation.end / scene.simulation.time_step;
  if (!(steps <= most_steps))
    findings.add(simulation->where,
                 fmt::format("simulation: end / time_step asks for {:.3g} steps; at most {:.0e} are "
                             "possible. Is a time in the wrong unit?",
                             steps, most_steps));
  const double frames = scene.simulation.end * scene.output.fps;
  if (!(frames <= most_frames))
    findings.add(simulation->where,
                 fmt::format("simulation: end * output.fps asks for {:.3g} frames; at most {:.0e} are "
                             "possible. Is a time in the wrong unit?",
                             frames, most_frames));
}

} // namespace pliant
