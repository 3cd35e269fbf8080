// The keys of a scene file, part three: materials.
#include "engine/scene/scene_schema_slot.h"

#include <numbers>

namespace pliant::schema {
namespace {

void* itself(void* object) {
  return object;
}
std::vector<void*> only_itself(void* object) {
  return {object};
}
const Material& material_of(const void* object) {
  return *static_cast<const Material*>(object);
}
bool elastic(const void* object) {
  return !material_of(object).fluid();
}
bool stiff(const void* object) {
  return elastic(object) || material_of(object).bonded();
}
bool relaxes(const void* object) {
  return material_of(object).relaxation_time.has_value();
}
bool fluid(const void* object) {
  return material_of(object).fluid();
}
bool projective(const void* object) {
  return elastic(object) && material_of(object).law == "projective";
}
bool may_invert(const void* object) {
  return elastic(object) && may_invert(material_of(object));
}
bool has_form(const void* object) {
  return material_of(object).law == "stvk" || material_of(object).law == "neo-hookean";
}
bool has_basis(const void* object) {
  return material_of(object).law == "basis";
}
bool has_calibration(const void* object) {
  return material_of(object).law == "basis" || material_of(object).law == "stvk";
}
bool flows(const void* object) {
  return material_of(object).plastic.given;
}
bool has_directions(const void* object) {
  return material_of(object).anisotropy.given;
}

const Table& turned_table() {
  static const Table table{"turned", "rotate = { ... }", "Turns directions about an axis.",
                           turn_keys(at<&Anisotropy::rotate_axis>, at<&Anisotropy::rotate_degrees>),
                           std::make_shared<Anisotropy>()};
  return table;
}

const Table& around_table() {
  static const Table table{
      "around",
      "around = { ... }",
      "An axis around which directions lie: radial, tangential, axial.",
      {{.name = "axis",
        .meaning = "axis; any length but zero",
        .slot = at<&Anisotropy::around_axis>,
        .example = "[0, 1, 0]",
        .required = true,
        .direction = true},
       {.name = "through", .meaning = "a point of it", .slot = at<&Anisotropy::around_through>, .unit = "m"}},
      std::make_shared<Anisotropy>()};
  return table;
}

} // namespace

const Table& basis_table() {
  static const Table table{
      "basis",
      "basis = { ... }",
      "Sums of A1 to A8 and B1 to B8 (Xu et al. 2018, Eq. 15) by their shares, at most four powers each.",
      {{.name = "g",
        .meaning = "energy of the dilatation",
        .slot = at<&Material::volume_basis>,
        .example = "{ A2 = 1.0 }",
        .required = true},
       {.name = "h",
        .meaning = "energy of each bond's stretch",
        .slot = at<&Material::bond_basis>,
        .example = "{ A4 = 0.5, B1 = 0.5 }",
        .required = true}},
      std::make_shared<Material>()};
  return table;
}

const Table& anisotropy_table() {
  static const Table table{
      "anisotropy",
      "anisotropy = { ... }",
      "Stiffness of bonds by direction (Eq. 18), 1 on average; directions of the body at rest, in the "
      "scene's axes.",
      {{.name = "strengths",
        .meaning = "along the three directions; only their ratios matter",
        .slot = at<&Anisotropy::strengths>,
        .range = {.low = 0, .above = true, .why = "bonds without stiffness hold nothing together"},
        .example = "[4, 0.25, 1]",
        .required = true},
       {.name = "directions", .meaning = "unit vectors at right angles", .slot = at<&Anisotropy::directions>},
       {.name = "rotate",
        .meaning = "instead: the scene's axes turned",
        .nested = {.table = &turned_table(), .add = itself, .all = only_itself}},
       {.name = "around",
        .meaning = "instead: radial, tangential and axial at each place",
        .nested = {.table = &around_table(), .add = itself, .all = only_itself},
        .applies = [](const void* object) { return static_cast<const Anisotropy*>(object)->around; }}},
      std::make_shared<Anisotropy>()};
  return table;
}

const Table& plastic_table() {
  static const Table table{
      "plastic",
      "plastic = { ... }",
      "Drucker-Prager plasticity: beyond its strength the material flows and stays as it is then.",
      {{.name = "cohesion",
        .meaning = "strength in shear without pressure (Mohr and Coulomb's c); without friction the material "
                   "yields in tension at twice this",
        .slot = at<&Plasticity::cohesion>,
        .unit = "Pa",
        .range = {.low = 0, .why = "less than no cohesion would push matter apart"},
        .example = "1e4",
        .required = true},
       {.name = "friction",
        .meaning = "angle of internal friction; 0 is von Mises",
        .slot = at<&Plasticity::friction>,
        .unit = "degrees",
        .range =
            {.low = 0, .high = 90, .below = true, .why = "at 90 degrees nothing yields under any pressure"},
        .scale = std::numbers::pi / 180},
       {.name = "hardening",
        .meaning = "cohesion gained by a unit of equivalent plastic strain",
        .slot = at<&Plasticity::hardening>,
        .unit = "Pa",
        .range = {.low = 0, .why = "matter that softens tears where it starts to, whatever the spacing"}}},
      std::make_shared<Plasticity>()};
  return table;
}

namespace {

Key plastic_key() {
  return {.name = "plastic",
          .meaning = "the material flows where its strength is exceeded; its law is \"ordinary\", or "
                     "its model \"viscoelastic\"",
          .nested = {.table = &plastic_table(),
                     .add = child<&Material::plastic>,
                     .all = only<&Material::plastic>},
          .applies = flows};
}

Key form_key() {
  return {.name = "form",
          .meaning =
              "laws \"stvk\" and \"neo-hookean\": \"exact\" (default) in every homogeneous deformation, or "
              "energies of \"bonds\" as in the paper",
          .slot = at<&Material::form>,
          .choices = {"exact", "bonds"},
          .example = "\"bonds\"",
          .applies = has_form};
}

Key basis_key() {
  return {.name = "basis",
          .meaning = "law \"basis\" only: the energies",
          .nested = {.table = &basis_table(), .add = itself, .all = only_itself},
          .applies = has_basis};
}

Key calibration_key() {
  return {.name = "calibration",
          .meaning = "laws \"basis\" and \"stvk\" only: \"xu2018\" (Eq. 26) gives another modulus and ratio, "
                     "and says so",
          .slot = at<&Material::calibration>,
          .choices = {"exact", "xu2018"},
          .applies = has_calibration};
}

Key anisotropy_key() {
  return {.name = "anisotropy",
          .meaning = "laws \"basis\", \"stvk\" and \"neo-hookean\" over bonds: stiffness by direction",
          .nested = {.table = &anisotropy_table(),
                     .add = child<&Material::anisotropy>,
                     .all = only<&Material::anisotropy>},
          .applies = has_directions};
}

} // namespace

const Table& material_table() {
  static const Table table{
      "materials",
      "[materials.<name>]",
      "A material.",
      {{.name = "model",
        .meaning = "kind of matter; \"viscoelastic\" is a fluid bonded to the neighbours it has now",
        .slot = at<&Material::model>,
        .choices = {"elastic", "fluid", "viscoelastic"}},
       {.name = "law",
        .meaning = "elastic law; \"projective\" has Poisson's ratio 1/4 always",
        .slot = at<&Material::law>,
        .choices = {"corotated", "ordinary", "projective", "basis", "stvk", "neo-hookean"},
        .applies = elastic},
       form_key(),
       basis_key(),
       calibration_key(),
       anisotropy_key(),
       {.name = "density",
        .meaning = "mass of a unit of volume",
        .slot = at<&Material::density>,
        .unit = "kg/m3",
        .range = {.low = 0, .above = true, .why = "matter without mass has no motion"}},
       {.name = "young",
        .meaning = "Young's modulus",
        .slot = at<&Material::young>,
        .unit = "Pa",
        .range = {.low = 0,
                  .high = 1e12,
                  .above = true,
                  .why = "matter without stiffness is not elastic, and none is stiffer than diamond"},
        .applies = stiff},
       {.name = "poisson",
        .meaning = "Poisson's ratio; at most 0.499 in solids; law = \"projective\": 1/4, in sheets 1/3",
        .slot = at<&Material::poisson>,
        .range = {.low = 0,
                  .high = 0.95,
                  .why = "at 0.5 the bulk modulus of solids is infinite, and that of sheets at 1"},
        .applies = stiff},
       {.name = "split",
        .meaning = "law \"projective\" only: share of the deviatoric term",
        .slot = at<&Material::split>,
        .range = unit_interval,
        .applies = projective},
       {.name = "inversion",
        .meaning =
            "laws over bonds: \"clamp\" pushes inverted neighbourhoods back; law \"projective\": \"clamp\" "
            "always, or \"swap\", which fails by design",
        .slot = at<&Material::inversion>,
        .choices = {"none", "clamp", "swap"},
        .example = "\"clamp\"",
        .applies = may_invert},
       {.name = "color",
        .meaning = "red, green, blue from 0 to 1",
        .slot = at<&Material::color>,
        .range = unit_interval},
       {.name = "fracture_energy",
        .meaning = "energy that a unit of crack takes: bonds break; by default never",
        .slot = at<&Material::fracture_energy>,
        .unit = "J/m2",
        .range = {.low = 0, .above = true, .why = "a crack that takes no energy is there from the start"},
        .example = "135",
        .applies = elastic},
       {.name = "critical_stretch",
        .meaning = "instead: bonds break beyond (1 + this) times their length at rest",
        .slot = at<&Material::critical_stretch>,
        .range = {.low = 0, .above = true, .why = "bonds at rest have a stretch of 1 and must not break"},
        .example = "0.02",
        .applies = elastic},
       plastic_key(),
       {.name = "relaxation_time",
        .meaning =
            "model \"viscoelastic\": in which shear stress falls to 1/e (Maxwell); by default it stays",
        .slot = at<&Material::relaxation_time>,
        .unit = "s",
        .range = {.low = 0, .above = true, .why = "what relaxes at once is a fluid"},
        .example = "0.5",
        .applies = relaxes},
       {.name = "viscosity",
        .meaning = "models \"fluid\" and \"viscoelastic\": dynamic viscosity; water 0.001, honey about 10",
        .slot = at<&Material::viscosity>,
        .unit = "Pa s",
        .range = {.low = 0, .why = "less than none would speed up what flows past itself"},
        .applies = fluid},
       {.name = "redistribution",
        .meaning = "models \"fluid\" and \"viscoelastic\": how strongly particles spread evenly",
        .slot = at<&Material::redistribution>,
        .range = unit_interval,
        .applies = fluid},
       {.name = "surface_tension",
        .meaning = "models \"fluid\" and \"viscoelastic\": pull on particles at the surface, towards the "
                   "fluid; 0.02 rounds drops off",
        .slot = at<&Material::surface_tension>,
        .range = {.low = 0, .high = 1, .why = "a stronger pull moves particles through each other"},
        .applies = fluid},
       {.name = "tensile_strength",
        .meaning =
            "models \"fluid\" and \"viscoelastic\": pull that the inside bears before it parts, so that "
            "what is drawn out gets thinner; by default it parts at once, as spray and sand do",
        .slot = at<&Material::tensile_strength>,
        .unit = "Pa",
        .range = {.low = 0, .why = "it is a pull"},
        .example = "1e4",
        .applies = fluid}},
      std::make_shared<Material>()};
  return table;
}

} // namespace pliant::schema
