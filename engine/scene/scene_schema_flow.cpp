// The keys of a scene file, part five: emitters and sinks of fluids.
#include "engine/scene/scene_schema_slot.h"

namespace pliant::schema {
namespace {

constexpr Range length{.low = 0, .above = true, .why = "a nozzle of no size lets nothing through"};

bool has_along(const void* emitter) {
  return static_cast<const Emitter*>(emitter)->along.has_value();
}

} // namespace

const Table& nozzle_table() {
  using E = Emitter;
  static const Table table{"nozzle",
                           "nozzle = { ... }",
                           "Exactly one of disc, rectangle.",
                           {{.name = "disc",
                             .meaning = "radius of a round nozzle",
                             .slot = at<&E::disc>,
                             .unit = "m",
                             .range = length,
                             .example = "0.01"},
                            {.name = "rectangle",
                             .meaning = "edges; the first lies along `along`, in dimension 2 in the plane",
                             .slot = at<&E::rectangle>,
                             .unit = "m",
                             .range = length,
                             .example = "[0.02, 0.01]"}},
                           std::make_shared<E>()};
  return table;
}

namespace {
void* itself(void* object) {
  return object;
}
std::vector<void*> only_itself(void* object) {
  return {object};
}
} // namespace

const Table& emitter_table() {
  using E = Emitter;
  static const Table table{
      "emitter",
      "[[emitter]]",
      "A nozzle from which a fluid comes, in layers of its lattice.",
      {{.name = "name",
        .meaning = "by default emitter-0, emitter-1, ...",
        .slot = at<&E::name>,
        .example = "\"tap\""},
       {.name = "material",
        .meaning = "name of a material that is a fluid",
        .slot = at<&E::material>,
        .example = "\"honey\"",
        .required = true},
       {.name = "nozzle",
        .meaning = "its shape, across the direction; such as { disc = 0.01 }",
        .required = true,
        .nested = {.table = &nozzle_table(), .add = itself, .all = only_itself}},
       {.name = "at", .meaning = "middle of the nozzle", .slot = at<&E::at>, .unit = "m"},
       {.name = "direction",
        .meaning = "in which the fluid comes out; any length but zero",
        .slot = at<&E::direction>,
        .direction = true},
       {.name = "along",
        .meaning =
            "of a rectangle, where its first edge lies; by default x, or z where that is the direction",
        .slot = at<&E::along>,
        .example = "[1, 0, 0]",
        .direction = true,
        .applies = has_along},
       {.name = "speed",
        .meaning = "of the fluid in the nozzle",
        .slot = at<&E::speed>,
        .unit = "m/s",
        .range = {.low = 0, .above = true, .why = "what does not move does not come out"},
        .example = "0.2",
        .required = true},
       {.name = "start",
        .meaning = "when the first layer is born",
        .slot = at<&E::start>,
        .unit = "s",
        .range = not_negative},
       {.name = "stop",
        .meaning = "when no more are; by default never",
        .slot = at<&E::stop>,
        .unit = "s",
        .range = positive,
        .example = "2.0"},
       {.name = "particles",
        .meaning = "the most that it ever emits; by default no limit",
        .slot = at<&E::particles>,
        .range = {.low = 1, .high = 2e9, .why = "particles are counted in 31 bits"},
        .example = "10000"},
       {.name = "when_full",
        .meaning = "where the scene has no room for its next layer: end the run (exit 6), or the emitter",
        .slot = at<&E::stops>,
        .choices = {"error", "stop"}},
       {.name = "color",
        .meaning = "red, green, blue from 0 to 1; by default the material's",
        .slot = at<&E::color>,
        .range = unit_interval,
        .example = "[0.85, 0.5, 0.1]"}},
      std::make_shared<E>()};
  return table;
}

const Table& sink_table() {
  using S = Sink;
  static const Table table{
      "sink",
      "[[sink]]",
      "A region in which particles of fluids are taken out at the end of each step.",
      {{.name = "name",
        .meaning = "by default sink-0, sink-1, ...",
        .slot = at<&S::name>,
        .example = "\"drain\""},
       {.name = "region",
        .meaning = "where; a plane takes what is on the side that its normal points away from",
        .required = true,
        .nested = {.table = &shape_table(), .add = child<&S::region>, .all = only<&S::region>}}},
      std::make_shared<S>()};
  return table;
}

} // namespace pliant::schema
