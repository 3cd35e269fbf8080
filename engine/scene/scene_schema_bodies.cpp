// The keys of a scene file, part two: shapes, bodies, obstacles.
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

template <Condition::Kind kind> void* append_condition(void* body) {
  auto& condition = static_cast<Body*>(body)->conditions.emplace_back();
  condition.kind = kind;
  return &condition;
}
template <Condition::Kind kind> std::vector<void*> every_condition(void* body) {
  std::vector<void*> found;
  for (auto& condition : static_cast<Body*>(body)->conditions)
    if (condition.kind == kind) found.push_back(&condition);
  return found;
}
template <Shape::Kind... kinds> bool of_kind(const void* shape) {
  return ((static_cast<const Shape*>(shape)->kind == kinds) || ...);
}
bool placed(const void* shape) {
  return !of_kind<Shape::Kind::mesh>(shape) || static_cast<const Shape*>(shape)->place.has_value();
}
bool slips(const void* boundary) {
  return static_cast<const Boundary*>(boundary)->slip;
}

constexpr double degree = std::numbers::pi / 180;
constexpr Range length{.low = 0, .above = true, .why = "a size of zero or less encloses nothing"};

Nested one_shape(void* (*add)(void*), std::vector<void*> (*all)(void*)) {
  return {.table = &shape_table(), .add = add, .all = all};
}

const Table& cylinder_table() {
  static const Table table{"cylinder",
                           "cylinder = { ... }",
                           "A cylinder along y.",
                           {{.name = "radius",
                             .meaning = "radius",
                             .slot = at<&Shape::radius>,
                             .unit = "m",
                             .range = length,
                             .example = "0.1",
                             .required = true},
                            {.name = "height",
                             .meaning = "length along its axis",
                             .slot = at<&Shape::height>,
                             .unit = "m",
                             .range = length,
                             .example = "0.4",
                             .required = true}},
                           std::make_shared<Shape>()};
  return table;
}

const Table& torus_table() {
  static const Table table{"torus",
                           "torus = { ... }",
                           "A torus around y.",
                           {{.name = "ring",
                             .meaning = "radius of the ring, to the middle of the tube",
                             .slot = at<&Shape::radius>,
                             .unit = "m",
                             .range = length,
                             .example = "0.4",
                             .required = true},
                            {.name = "tube",
                             .meaning = "radius of the tube, at most that of the ring",
                             .slot = at<&Shape::tube>,
                             .unit = "m",
                             .range = length,
                             .example = "0.1",
                             .required = true}},
                           std::make_shared<Shape>()};
  return table;
}

const Table& rotate_table() {
  static const Table table{"rotate", "rotate = { ... }", "Turns a shape about its centre.",
                           turn_keys(at<&Shape::rotate_axis>, at<&Shape::rotate_degrees>),
                           std::make_shared<Shape>()};
  return table;
}

} // namespace

const Table& shape_table() {
  using K = Shape::Kind;
  static const Table table{
      "shape",
      "shape = { ... }",
      "Exactly one of box, sphere, cylinder, torus, mesh, plane, sheet.",
      {{.name = "box",
        .meaning = "edge lengths",
        .slot = at<&Shape::size>,
        .unit = "m",
        .range = length,
        .example = "[0.4, 0.2, 0.2]",
        .applies = of_kind<K::box>},
       {.name = "sphere",
        .meaning = "radius",
        .slot = at<&Shape::radius>,
        .unit = "m",
        .range = length,
        .example = "0.2",
        .applies = of_kind<K::sphere>},
       {.name = "cylinder",
        .meaning = "a cylinder along y",
        .nested = {.table = &cylinder_table(), .add = itself, .all = only_itself},
        .applies = of_kind<K::cylinder>},
       {.name = "torus",
        .meaning = "a torus around y",
        .nested = {.table = &torus_table(), .add = itself, .all = only_itself},
        .applies = of_kind<K::torus>},
       {.name = "mesh",
        .meaning = "file of a surface: OBJ, OFF, PLY or STL; closed, unless the body has a thickness",
        .slot = at<&Shape::mesh>,
        .example = "\"armadillo.off\"",
        .applies = of_kind<K::mesh>},
       {.name = "plane",
        .meaning = "normal, towards the free side",
        .slot = at<&Shape::normal>,
        .example = "[0, 1, 0]",
        .direction = true,
        .applies = of_kind<K::plane>},
       {.name = "sheet",
        .meaning = "width along x and height along y of a single layer; its body needs a thickness",
        .slot = at<&Shape::sheet>,
        .unit = "m",
        .range = length,
        .example = "[1, 0.5]",
        .applies = of_kind<K::sheet>},
       {.name = "fit",
        .meaning = "of a mesh: longest side of its box after scaling; by default as in the file",
        .slot = at<&Shape::fit>,
        .unit = "m",
        .range = length,
        .example = "1.0",
        .applies = of_kind<K::mesh>},
       {.name = "offset",
        .meaning = "of a plane: points x with normal . x = offset",
        .slot = at<&Shape::offset>,
        .unit = "m",
        .applies = of_kind<K::plane>},
       {.name = "at",
        .meaning = "centre (of a mesh: of its box; by default where the file puts it); a point of a plane",
        .slot = at<&Shape::at>,
        .unit = "m",
        .applies = placed},
       {.name = "rotate",
        .meaning = "turned about its centre",
        .nested = {.table = &rotate_table(), .add = itself, .all = only_itself},
        .applies = of_kind<K::box, K::sphere, K::cylinder, K::torus, K::mesh, K::sheet>}},
      std::make_shared<Shape>()};
  return table;
}

const Table& rotation_table() {
  static const Table table{
      "rotation",
      "rotation = { ... }",
      "A steady turn about an axis.",
      {{.name = "axis",
        .meaning = "axis; any length but zero",
        .slot = at<&Motion::axis>,
        .example = "[1, 0, 0]",
        .required = true,
        .direction = true},
       {.name = "about", .meaning = "a point of the axis", .slot = at<&Motion::about>, .unit = "m"},
       {.name = "rate_degrees",
        .meaning = "rate",
        .slot = at<&Motion::rate>,
        .unit = "degrees/s",
        .example = "90",
        .required = true,
        .scale = degree}},
      std::make_shared<Motion>()};
  return table;
}

const Table& region_table() {
  static const Table table{
      "region",
      "[[body.region]]",
      "Part of a body that is of another material; later ones win.",
      {{.name = "region",
        .meaning = "where, in the initial position",
        .required = true,
        .nested = one_shape(child<&MaterialRegion::region>, only<&MaterialRegion::region>)},
       {.name = "material",
        .meaning = "name of a material",
        .slot = at<&MaterialRegion::material>,
        .example = "\"rubber\"",
        .required = true}},
      std::make_shared<MaterialRegion>()};
  return table;
}

namespace {
Key condition_region() {
  return {.name = "region",
          .meaning = "which particles, in the initial position",
          .required = true,
          .nested = one_shape(child<&Condition::region>, only<&Condition::region>)};
}
const Table& fixed_table() {
  static const Table table{"fixed",
                           "[[body.fixed]]",
                           "Particles that stay where they are.",
                           {condition_region()},
                           std::make_shared<Condition>()};
  return table;
}
} // namespace

const Table& moved_table() {
  using C = Condition;
  static const Table table{
      "moved",
      "[[body.moved]]",
      "Particles that are moved as a rigid whole.",
      {condition_region(),
       {.name = "velocity", .meaning = "velocity", .slot = at<&C::motion, &Motion::velocity>, .unit = "m/s"},
       {.name = "rotation",
        .meaning = "a steady turn about an axis",
        .nested = {.table = &rotation_table(), .add = child<&C::motion>, .all = only<&C::motion>}},
       {.name = "start",
        .meaning = "when the motion starts",
        .slot = at<&C::motion, &Motion::start>,
        .unit = "s",
        .range = not_negative},
       {.name = "end",
        .meaning = "when it ends; by default never",
        .slot = at<&C::motion, &Motion::end>,
        .unit = "s",
        .range = positive,
        .example = "2.0"},
       {.name = "release",
        .meaning = "set the particles free at the end",
        .slot = at<&C::motion, &Motion::release>,
        .example = "false"}},
      std::make_shared<C>()};
  return table;
}

const Table& loaded_table() {
  using C = Condition;
  static const Table table{"loaded",
                           "[[body.loaded]]",
                           "Particles that a force pulls.",
                           {condition_region(),
                            {.name = "force",
                             .meaning = "in total, shared by mass",
                             .slot = at<&C::force>,
                             .unit = "N",
                             .example = "[0, -1, 0]",
                             .required = true},
                            {.name = "start",
                             .meaning = "when the force starts",
                             .slot = at<&C::start>,
                             .unit = "s",
                             .range = not_negative},
                            {.name = "end",
                             .meaning = "when it ends; by default never",
                             .slot = at<&C::end>,
                             .unit = "s",
                             .range = positive,
                             .example = "2.0"}},
                           std::make_shared<C>()};
  return table;
}

const Table& cut_table() {
  static const Table table{"cut",
                           "[[body.cut]]",
                           "A notch: bonds that cross it are not made.",
                           {{.name = "region",
                             .meaning = "a box between the particles that it parts; thin, if they all stay",
                             .required = true,
                             .nested = one_shape(child<&Cut::region>, only<&Cut::region>)}},
                           std::make_shared<Cut>()};
  return table;
}

const Table& deformed_table() {
  using D = DeformedRegion;
  static const Table table{
      "deformed",
      "[[body.deformed]]",
      "Part of a body that starts deformed, before `deform` and `start` of the whole; each goes on from "
      "those "
      "above it.",
      {{.name = "region",
        .meaning = "which particles, in the rest position",
        .required = true,
        .nested = one_shape(child<&D::region>, only<&D::region>)},
       {.name = "deform",
        .meaning = "the deformation, as rows; a negative determinant turns them inside out",
        .slot = at<&D::deform>,
        .example = "[[-0.6, 0, 0], [0, 1, 0], [0, 0, 1]]",
        .required = true},
       {.name = "about",
        .meaning = "the point that stays; by default their centre of mass",
        .slot = at<&D::about>,
        .unit = "m",
        .example = "[0, 0.5, 0]"}},
      std::make_shared<D>()};
  return table;
}

const Table& body_table() {
  using K = Condition::Kind;
  using How = Nested::How;
  static const Table table{
      "body",
      "[[body]]",
      "A solid, filled with particles.",
      {{.name = "name",
        .meaning = "by default body-0, body-1, ...",
        .slot = at<&Body::name>,
        .example = "\"armadillo\""},
       {.name = "material",
        .meaning = "name of a material",
        .slot = at<&Body::material>,
        .example = "\"rubber\"",
        .required = true},
       {.name = "shape",
        .meaning = "the solid",
        .required = true,
        .nested = one_shape(child<&Body::shape>, only<&Body::shape>)},
       {.name = "thickness",
        .meaning =
            "of a sheet or a mesh: makes one layer of particles of it; dimension 2: depth, by default 1",
        .slot = at<&Body::thickness>,
        .unit = "m",
        .range = length,
        .example = "0.001"},
       {.name = "horizon",
        .meaning = "reach of its bonds; by default that of the simulation",
        .slot = at<&Body::horizon>,
        .unit = "spacings",
        .range = horizon_range,
        .example = "3.1"},
       {.name = "velocity", .meaning = "initial velocity", .slot = at<&Body::velocity>, .unit = "m/s"},
       {.name = "spin",
        .meaning = "initial angular velocity about the centre of mass",
        .slot = at<&Body::spin>,
        .unit = "rad/s"},
       {.name = "deform",
        .meaning = "initial deformation about the centre of mass, as rows",
        .slot = at<&Body::deform>},
       {.name = "deformed",
        .meaning = "parts that start deformed",
        .nested = {&deformed_table(), How::list, append<&Body::deformed>, every<&Body::deformed>}},
       {.name = "start",
        .meaning =
            "collapse to x = centre, to a line, to a point; random positions; or mirrored in x = centre",
        .slot = at<&Body::start>,
        .choices = {"", "flat", "line", "point", "random", "mirror"}},
       {.name = "color",
        .meaning = "red, green, blue from 0 to 1; by default the material's",
        .slot = at<&Body::color>,
        .range = unit_interval,
        .example = "[0.8, 0.3, 0.2]"},
       {.name = "self_contact", .meaning = "takes part in contact.self", .slot = at<&Body::self_contact>},
       {.name = "fixed",
        .meaning = "particles that stay",
        .nested = {&fixed_table(), How::list, append_condition<K::fixed>, every_condition<K::fixed>}},
       {.name = "moved",
        .meaning = "particles that are moved",
        .nested = {&moved_table(), How::list, append_condition<K::moved>, every_condition<K::moved>}},
       {.name = "loaded",
        .meaning = "particles that a force pulls",
        .nested = {&loaded_table(), How::list, append_condition<K::loaded>, every_condition<K::loaded>}},
       {.name = "region",
        .meaning = "parts of another material",
        .nested = {&region_table(), How::list, append<&Body::regions>, every<&Body::regions>}},
       {.name = "cut",
        .meaning = "notches",
        .nested = {&cut_table(), How::list, append<&Body::cuts>, every<&Body::cuts>}}},
      std::make_shared<Body>()};
  return table;
}

const Table& boundary_table() {
  using B = Boundary;
  static const Table table{
      "boundary",
      "[[boundary]]",
      "An obstacle that particles may not enter.",
      {{.name = "name",
        .meaning = "by default boundary-0, boundary-1, ...",
        .slot = at<&B::name>,
        .example = "\"floor\""},
       {.name = "shape",
        .meaning = "the obstacle",
        .required = true,
        .nested = one_shape(child<&B::shape>, only<&B::shape>)},
       {.name = "condition",
        .meaning = "whether particles stick to it or slide",
        .slot = at<&B::slip>,
        .choices = {"no-slip", "slip"}},
       {.name = "friction",
        .meaning = "Coulomb's coefficient, where it slips",
        .slot = at<&B::friction>,
        .range = not_negative,
        .applies = slips},
       {.name = "inside",
        .meaning = "keep particles inside the shape instead of outside",
        .slot = at<&B::inside>},
       {.name = "velocity",
        .meaning = "velocity of the obstacle",
        .slot = at<&B::motion, &Motion::velocity>,
        .unit = "m/s"},
       {.name = "rotation",
        .meaning = "a steady turn about an axis",
        .nested = {.table = &rotation_table(), .add = child<&B::motion>, .all = only<&B::motion>}},
       {.name = "start",
        .meaning = "when its motion starts",
        .slot = at<&B::motion, &Motion::start>,
        .unit = "s",
        .range = not_negative},
       {.name = "end",
        .meaning = "when its motion ends, or it is taken away; by default never",
        .slot = at<&B::motion, &Motion::end>,
        .unit = "s",
        .range = positive,
        .example = "2.0"},
       {.name = "release",
        .meaning = "take the obstacle away at the end",
        .slot = at<&B::motion, &Motion::release>,
        .example = "false"},
       {.name = "visible", .meaning = "is drawn", .slot = at<&B::visible>}},
      std::make_shared<B>()};
  return table;
}

} // namespace pliant::schema
