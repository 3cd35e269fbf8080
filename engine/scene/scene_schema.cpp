// The keys of a scene file, part one: the scene and its settings.
#include "engine/scene/scene_schema_slot.h"

#include <algorithm>

namespace pliant::schema {
namespace {

void* add_render(void* scene) {
  auto& render = static_cast<Scene*>(scene)->render;
  render.given = true;
  return &render;
}
void* add_camera(void* render) {
  return &static_cast<RenderSettings*>(render)->camera.emplace();
}
std::vector<void*> every_camera(void* render) {
  auto& camera = static_cast<RenderSettings*>(render)->camera;
  return camera ? std::vector<void*>{&*camera} : std::vector<void*>{};
}
void* add_domain(void* scene) {
  auto& domain = static_cast<Scene*>(scene)->domain;
  domain.given = true;
  return &domain;
}
bool has_domain(const void* scene) {
  return static_cast<const Scene*>(scene)->domain.given;
}
bool emits(const void* scene) {
  return !static_cast<const Scene*>(scene)->emitters.empty();
}
bool has_sinks(const void* scene) {
  return !static_cast<const Scene*>(scene)->sinks.empty();
}
bool has_capacity(const void* simulation) {
  return static_cast<const SimulationSettings*>(simulation)->capacity.has_value();
}
bool has_fluids(const void* scene) {
  return static_cast<const Scene*>(scene)->flows();
}
bool by_power(const void* simulation) {
  return static_cast<const SimulationSettings*>(simulation)->influence == "power";
}
bool in_a_plane(const void* simulation) {
  return static_cast<const SimulationSettings*>(simulation)->dimension == 2;
}
Slot allowances(void* scene) {
  auto& s = *static_cast<Scene*>(scene);
  return Flags{{&s.allow_overlap, &s.allow_sparse}};
}

const Table& solver_table() {
  using S = SolverSettings;
  static const Table table{
      "solver",
      "[solver]",
      "The global step.",
      {{.name = "method",
        .meaning = "auto chooses by stiffness, Poisson's ratio and tolerance, and says why",
        .slot = at<&S::method>,
        .choices = {"auto", "chebyshev", "jacobi", "position", "direct", "lbfgs", "newton"}},
       {.name = "preconditioner",
        .meaning = "of newton and lbfgs",
        .slot = at<&S::preconditioner>,
        .choices = {"auto", "diagonal", "multilevel", "direct"}},
       {.name = "tolerance",
        .meaning = "relative residual at which a step is solved",
        .slot = at<&S::tolerance>,
        .range = {.low = 1e-12,
                  .high = 1,
                  .why = "less than 1e-12 is lost in rounding even in double precision"}},
       {.name = "energy_tolerance",
        .meaning =
            "relative energy error at which a step is solved, in place of tolerance; by default 1e-4 for "
            "materials of law basis, stvk and neo-hookean, else none",
        .slot = at<&S::energy_tolerance>,
        .range = {.low = 1e-10,
                  .high = 0.1,
                  .why = "the sum that it is a share of is known to some 1e-12 in double precision, and a "
                         "float's slopes reach about 1e-6"},
        .example = "1e-4"},
       {.name = "iterations",
        .meaning = "a cap; reaching it is reported",
        .slot = at<&S::iterations>,
        .range = {.low = 1,
                  .high = 1e6,
                  .why = "one iteration is one evaluation of forces or of their derivative"}},
       {.name = "integrator",
        .meaning = "time integration",
        .slot = at<&S::integrator>,
        .choices = {"implicit-euler", "bdf2"}},
       {.name = "under_relaxation",
        .meaning = "factor on each sweep's correction",
        .slot = at<&S::under_relaxation>,
        .range = {.low = 0, .high = 1, .above = true, .why = "above 1 the sweeps diverge"}},
       {.name = "delay",
        .meaning = "plain sweeps before acceleration",
        .slot = at<&S::delay>,
        .range = {.low = 0, .high = 1e6}},
       {.name = "spectral_radius",
        .meaning = "of the iteration matrix; by default a bound is computed",
        .slot = at<&S::spectral_radius>,
        .range = {.low = 0,
                  .high = 1,
                  .above = true,
                  .below = true,
                  .why = "the sweeps converge only where it is below 1"},
        .example = "0.99"},
       {.name = "restore_momentum",
        .meaning = "undo the momentum error of a step that stopped early",
        .slot = at<&S::restore_momentum>}},
      std::make_shared<S>()};
  return table;
}

const Table& contact_table() {
  using S = ContactSettings;
  static const Table table{
      "contact",
      "[contact]",
      "Contact between particles.",
      {{.name = "bodies", .meaning = "between particles of different bodies", .slot = at<&S::bodies>},
       {.name = "self", .meaning = "between particles of one body that are not bonded", .slot = at<&S::self>},
       {.name = "distance",
        .meaning = "at which particles touch",
        .slot = at<&S::distance>,
        .unit = "spacings",
        .range = {.low = 0,
                  .high = 2,
                  .above = true,
                  .why = "farther apart, particles that do not touch would repel"}},
       {.name = "friction",
        .meaning = "Coulomb's coefficient between particles",
        .slot = at<&S::friction>,
        .range = not_negative}},
      std::make_shared<S>()};
  return table;
}

const Table& output_table() {
  using S = OutputSettings;
  static const Table table{
      "output",
      "[output]",
      "What is written.",
      {{.name = "fps",
        .meaning = "frames a second of simulated time",
        .slot = at<&S::fps>,
        .unit = "1/s",
        .range = positive},
       {.name = "fields",
        .meaning = "fields stored with the positions",
        .slot = at<&S::fields>,
        .choices = {"velocity", "displacement", "strain", "energy", "damage", "plastic_strain"}},
       {.name = "data", .meaning = "write run.vtkhdf and run.xmf", .slot = at<&S::data>},
       {.name = "checkpoint_every",
        .meaning = "frames between checkpoints; 0: only at the end and when interrupted",
        .slot = at<&S::checkpoint_every>,
        .unit = "frames",
        .range = {.low = 0, .high = 1e6}}},
      std::make_shared<S>()};
  return table;
}

} // namespace

const Table& simulation_table() {
  using S = SimulationSettings;
  static const Table table{
      "simulation",
      "[simulation]",
      "Space and time.",
      {{.name = "spacing",
        .meaning = "distance between particles",
        .slot = at<&S::spacing>,
        .unit = "m",
        .range = {.low = 0, .above = true, .why = "particles need room between them"},
        .example = "0.02",
        .required = true},
       {.name = "horizon",
        .meaning = "reach of a bond; never on a shell of the lattice (1.87, 2.1, 2.35, 2.6, 3.1)",
        .slot = at<&S::horizon>,
        .unit = "spacings",
        .range = horizon_range},
       {.name = "time_step",
        .meaning = "time step; a number or a fraction such as \"1/60\"",
        .slot = at<&S::time_step>,
        .unit = "s",
        .range = positive},
       {.name = "end",
        .meaning = "time at which the simulation ends",
        .slot = at<&S::end>,
        .unit = "s",
        .range = positive},
       {.name = "gravity", .meaning = "acceleration of everything", .slot = at<&S::gravity>, .unit = "m/s2"},
       {.name = "weights",
        .meaning = "bond weights: corrected so that moments match, or merely normalised",
        .slot = at<&S::weights>,
        .choices = {"matched", "normalised"}},
       {.name = "weight_exponent",
        .meaning = "p of the influence r^p",
        .slot = at<&S::weight_exponent>,
        .range = {.low = -3,
                  .high = 3,
                  .why = "beyond it the nearest or the farthest bonds alone would count"},
        .applies = by_power},
       {.name = "influence",
        .meaning = "of bonds, before moments are matched: r^p, 1, (1 + r/horizon)^-1 or r/horizon",
        .slot = at<&S::influence>,
        .choices = {"power", "constant", "decreasing", "increasing"}},
       {.name = "dimension",
        .meaning = "2: everything lies and moves in the plane z = 0",
        .slot = at<&S::dimension>,
        .range = {.low = 2, .high = 3, .why = "matter of one dimension is not simulated"}},
       {.name = "plane",
        .meaning = "dimension 2: what is zero across the plane",
        .slot = at<&S::plane>,
        .choices = {"strain", "stress"},
        .applies = in_a_plane},
       {.name = "capacity",
        .meaning = "particles that there may be at once, with emitters; without them what the bodies have",
        .slot = at<&S::capacity>,
        .range = {.low = 1, .high = 2e9, .why = "particles are counted in 31 bits"},
        .example = "72000",
        .applies = has_capacity}},
      std::make_shared<S>()};
  return table;
}

const Table& camera_table() {
  static const Table table{"camera",
                           "camera = { ... }",
                           "The view. Without it the camera frames the scene.",
                           {{.name = "eye",
                             .meaning = "where it stands",
                             .slot = at<&Camera::eye>,
                             .unit = "m",
                             .example = "[2, 1.5, 3]",
                             .required = true},
                            {.name = "look",
                             .meaning = "what it looks at",
                             .slot = at<&Camera::look>,
                             .unit = "m",
                             .example = "[0, 0.5, 0]",
                             .required = true},
                            {.name = "up", .meaning = "upwards", .slot = at<&Camera::up>, .direction = true},
                            {.name = "fov",
                             .meaning = "angle of view, vertical",
                             .slot = at<&Camera::fov>,
                             .unit = "degrees",
                             .range = {.low = 1, .high = 170, .why = "a wider view is not a picture"}}},
                           std::make_shared<Camera>()};
  return table;
}

const Table& render_table() {
  using R = RenderSettings;
  static const Table table{
      "render",
      "[render]",
      "Pictures.",
      {{.name = "size",
        .meaning = "width, height",
        .slot = at<&R::size>,
        .unit = "pixels",
        .range = {.low = 16, .high = 8192, .why = "graphics devices draw no more at once"}},
       {.name = "camera",
        .meaning = "the view",
        .nested = {.table = &camera_table(), .add = add_camera, .all = every_camera}},
       {.name = "show",
        .meaning = "skinned surface, where there is one, or particles",
        .slot = at<&R::show>,
        .choices = {"surface", "particles"}},
       {.name = "color",
        .meaning = "by body, or a field",
        .slot = at<&R::color>,
        .choices = {"body", "velocity", "displacement", "strain", "energy", "damage", "plastic_strain"}},
       {.name = "range",
        .meaning = "least and greatest value of the field's colours; by default those that occur",
        .slot = at<&R::range>,
        .example = "[0, 1]"},
       {.name = "ground", .meaning = "draw the ground", .slot = at<&R::ground>},
       {.name = "samples",
        .meaning = "of a pixel, against jagged edges",
        .slot = at<&R::samples>,
        .range = {.low = 1, .high = 16, .why = "graphics devices take no more"}}},
      std::make_shared<R>()};
  return table;
}

const Table& root() {
  using How = Nested::How;
  static const Table table{
      "scene",
      "",
      "The scene. SI units: m, kg, s, Pa. Numbers may be fractions: \"1/30\".",
      {{.name = "format",
        .meaning = "of this file",
        .slot = at<&Scene::format>,
        .range = {.low = 1, .high = 1, .why = "this version reads format 1"}},
       {.name = "name",
        .meaning = "by default that of the file",
        .slot = at<&Scene::name>,
        .example = "\"drop\""},
       {.name = "description",
        .meaning = "for people",
        .slot = at<&Scene::description>,
        .example = "\"a drop\""},
       {.name = "allow",
        .meaning = "faults to put up with",
        .slot = allowances,
        .choices = {"overlap", "sparse"}},
       {.name = "simulation",
        .meaning = "space and time",
        .required = true,
        .nested = {.table = &simulation_table(),
                   .add = child<&Scene::simulation>,
                   .all = only<&Scene::simulation>}},
       {.name = "solver",
        .meaning = "the global step",
        .nested = {.table = &solver_table(), .add = child<&Scene::solver>, .all = only<&Scene::solver>}},
       {.name = "contact",
        .meaning = "contact between particles",
        .nested = {.table = &contact_table(), .add = child<&Scene::contact>, .all = only<&Scene::contact>}},
       {.name = "fluid",
        .meaning = "how fluids are solved",
        .nested = {.table = &fluid_table(), .add = child<&Scene::fluid>, .all = only<&Scene::fluid>},
        .applies = has_fluids},
       {.name = "domain",
        .meaning = "where fluids may be",
        .nested = {.table = &domain_table(), .add = add_domain, .all = only<&Scene::domain>},
        .applies = has_domain},
       {.name = "materials",
        .meaning = "materials by name",
        .required = true,
        .nested = {&material_table(), How::named, append<&Scene::materials>, every<&Scene::materials>}},
       {.name = "body",
        .meaning = "solids and fluids",
        .nested = {&body_table(), How::list, append<&Scene::bodies>, every<&Scene::bodies>}},
       {.name = "boundary",
        .meaning = "obstacles",
        .nested = {&boundary_table(), How::list, append<&Scene::boundaries>, every<&Scene::boundaries>}},
       {.name = "emitter",
        .meaning = "nozzles from which fluids come",
        .nested = {&emitter_table(), How::list, append<&Scene::emitters>, every<&Scene::emitters>},
        .applies = emits},
       {.name = "sink",
        .meaning = "regions that take particles of fluids out",
        .nested = {&sink_table(), How::list, append<&Scene::sinks>, every<&Scene::sinks>},
        .applies = has_sinks},
       {.name = "output",
        .meaning = "what is written",
        .nested = {.table = &output_table(), .add = child<&Scene::output>, .all = only<&Scene::output>}},
       {.name = "render",
        .meaning = "pictures",
        .nested = {.table = &render_table(), .add = add_render, .all = only<&Scene::render>}}},
      std::make_shared<Scene>()};
  return table;
}

const Key* Table::find(std::string_view wanted) const {
  const auto found =
      std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return key.name == wanted; });
  return found == keys.end() ? nullptr : &*found;
}

std::vector<const Table*> all_tables() {
  std::vector<const Table*> tables{&root()};
  for (std::size_t i = 0; i < tables.size(); ++i)
    for (const Key& key : tables[i]->keys)
      if (key.nested.table && std::find(tables.begin(), tables.end(), key.nested.table) == tables.end())
        tables.push_back(key.nested.table);
  return tables;
}

} // namespace pliant::schema
