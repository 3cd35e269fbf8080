// The schema and the parser agree: every key is accepted, an unknown one refused, and both outputs list them
// all.
#include "parse.h"

#include "engine/scene/scene_schema.h"

#include <nlohmann/json.hpp>

namespace pliant {
namespace {

using nlohmann::json;
using schema::Key;
using schema::Nested;
using schema::Table;
using testing::HasSubstr;

std::string toml(const json& value) {
  return value.dump();
}

/// A value of a key, as TOML: its default, or else its example.
std::string good_value(const Key& key, const Table& table) {
  if (!key.example.empty()) return std::string(key.example);
  const json value = schema::value_json(key, table.defaults.get());
  return value.is_null() ? "" : toml(value);
}

std::string good_table(const Table& table, const Key* also = nullptr);

/// "key = value" for each required key and `also`.
std::string entry(const Key& key, const Table& table) {
  std::string value;
  if (!key.nested.table)
    value = good_value(key, table);
  else if (key.nested.how == Nested::How::one)
    value = good_table(*key.nested.table);
  else if (key.nested.how == Nested::How::list)
    value = "[" + good_table(*key.nested.table) + "]";
  else
    value = "{rubber = " + good_table(*key.nested.table) + "}";
  return std::string(key.name) + " = " + value;
}

std::string good_table(const Table& table, const Key* also) {
  std::string text;
  const auto add = [&](const Key& key) { text += (text.empty() ? "" : ", ") + entry(key, table); };
  if (&table == &schema::shape_table()) {
    const std::string_view name = also ? also->name : "box";
    if (name == "fit") add(*table.find("mesh"));
    if (name == "offset") add(*table.find("plane"));
    if (name == "at" || name == "rotate") add(*table.find("box"));
    add(also ? *also : *table.find("box"));
    return "{" + text + "}";
  }
  if (&table == &schema::nozzle_table()) {
    add(also ? *also : *table.find("disc"));
    return "{" + text + "}";
  }
  const bool laid = also && also->name == "along"; // which a disc has not
  if (laid) text = "nozzle = {rectangle = [1, 1]}";
  for (const Key& key : table.keys)
    if ((key.required && !(laid && key.name == "nozzle")) || &key == also) add(key);
  // Keys that need another.
  const auto named = [&](auto... names) { return also && ((also->name == names) || ...); };
  const bool plain = named("law", "young", "poisson", "fracture_energy", "critical_stretch");
  const bool bonded = named("relaxation_time"),
             fluid = bonded || named("viscosity", "redistribution", "surface_tension", "tensile_strength");
  if (&table == &schema::material_table() && fluid)
    text += bonded ? ", model = \"viscoelastic\"" : ", model = \"fluid\"";
  if (&table == &schema::material_table() && also && also->applies && !plain && !fluid) {
    const bool basis = also->name == "basis",
               stretch = also->name == "form" || also->name == "calibration" || also->name == "anisotropy";
    text += std::string(", law = \"") +
            (basis                     ? "basis"
             : stretch                 ? "stvk"
             : also->name == "plastic" ? "ordinary"
                                       : "projective") +
            "\"";
  }
  if (&table == &schema::render_table() && also && also->name == "range") text += ", color = \"strain\"";
  if (&table == &schema::simulation_table() && also && also->name == "plane") text += ", dimension = 2";
  return "{" + text + "}";
}

/// A scene in which `inner` stands in the place of that table.
std::string scene_around(const Table& table, const std::string& inner) {
  const std::string shape = "shape = {box = [1, 1, 1]}";
  std::string simulation = "{spacing = 0.1}", materials = "{rubber = {}}", body, extra;
  const std::string plain_body = "{material = \"rubber\", " + shape + "}";
  const std::string_view name = table.name;
  body = plain_body;
  const auto in_body = [&](const std::string& more) {
    body = "{material = \"rubber\", " + shape + ", " + more + "}";
  };
  if (name == "simulation")
    simulation = inner;
  else if (name == "materials")
    materials = "{rubber = " + inner + "}";
  else if (name == "basis")
    materials = "{rubber = {law = \"basis\", basis = " + inner + "}}";
  else if (name == "plastic")
    materials = "{rubber = {plastic = " + inner + "}}";
  else if (name == "anisotropy")
    materials = "{rubber = {law = \"stvk\", anisotropy = " + inner + "}}";
  else if (name == "turned" || name == "around")
    materials = "{rubber = {law = \"stvk\", anisotropy = {strengths = [2, 1, 1], " +
                std::string(name == "turned" ? "rotate" : name) + " = " + inner + "}}}";
  else if (name == "body")
    body = inner;
  else if (name == "shape" && inner.starts_with("{sheet")) // of a body, since it keeps nothing out
    body = "{material = \"rubber\", thickness = 0.01, shape = " + inner + "}";
  else if (name == "shape") // of an obstacle, where planes are allowed
    extra = "boundary = [{shape = " + inner + "}]\n";
  else if (name == "cylinder" || name == "torus")
    body = "{material = \"rubber\", shape = {" + std::string(name) + " = " + inner + "}}";
  else if (name == "rotate")
    body = "{material = \"rubber\", shape = {box = [1, 1, 1], rotate = " + inner + "}}";
  else if (name == "rotation")
    in_body("moved = [{region = {box = [1, 1, 1]}, rotation = " + inner + "}]");
  else if (name == "fixed" || name == "moved" || name == "loaded" || name == "region" || name == "deformed" ||
           name == "cut")
    in_body(std::string(name) + " = [" + inner + "]");
  else if (name == "boundary")
    extra = "boundary = [" + inner + "]\n";
  else if (name == "camera")
    extra = "render = {camera = " + inner + "}\n";
  else if (name == "emitter" || name == "nozzle" || name == "sink") {
    materials = "{honey = {model = \"fluid\"}}";
    body = "{material = \"honey\", " + shape + "}";
    simulation = "{spacing = 0.1, capacity = 2000}";
    extra = name == "nozzle" ? "emitter = [{material = \"honey\", speed = 1, nozzle = " + inner + "}]\n"
                             : std::string(name) + " = [" + inner + "]\n";
  } else if (name == "fluid" || name == "domain") {
    materials = "{rubber = {model = \"fluid\"}}";
    extra = std::string(name) + " = " + inner + "\n";
  } else
    extra = std::string(name) + " = " + inner + "\n";                 // solver, contact, output, render
  if (name == "body" && inner.find("thickness") != std::string::npos) // which a box has in a plane scene only
    simulation = "{spacing = 0.1, dimension = 2}";
  if (name == "simulation" && inner.find("capacity") != std::string::npos) // which fluids alone have
    materials = "{rubber = {model = \"fluid\"}}";
  return extra + "simulation = " + simulation + "\nmaterials = " + materials + "\nbody = [" + body + "]\n";
}

std::string scene_with(const Table& table, const Key& key) {
  if (&table == &schema::root()) {
    if (key.name == "fluid" || key.name == "domain" || key.name == "emitter" || key.name == "sink")
      return scene_around(*key.nested.table, good_table(*key.nested.table));
    std::string text;
    for (const Key& other : table.keys)
      if (other.required || other.name == "body" || &other == &key) text += entry(other, table) + "\n";
    return text;
  }
  return scene_around(table, good_table(table, &key));
}

TEST(SceneSchema, EveryKeyIsAccepted) {
  std::size_t count = 0;
  for (const Table* table : schema::all_tables())
    for (const Key& key : table->keys) {
      ++count;
      if (!key.nested.table) {
        ASSERT_NE(good_value(key, *table), "") << key.name << " has neither a default nor an example";
      }
      // release needs an end; only this key's own rules are of interest.
      std::string text = scene_with(*table, key);
      EXPECT_EQ(complaint(text), "") << table->name << "." << key.name << "\n" << text;
    }
  EXPECT_GT(count, 80u);
}

TEST(SceneSchema, AnUnknownKeyIsRefusedInEveryTable) {
  for (const Table* table : schema::all_tables()) {
    std::string text;
    if (table == &schema::root()) {
      text = small_scene;
      text.insert(0, "qqqqqq = 1\n");
    } else {
      std::string inner = good_table(*table);
      inner.insert(1, inner == "{}" ? "qqqqqq = 1" : "qqqqqq = 1, ");
      text = scene_around(*table, inner);
    }
    EXPECT_THAT(complaint(text), HasSubstr("unknown key 'qqqqqq'")) << table->name << "\n" << text;
  }
}

TEST(SceneSchema, ListsWhatIsRead) {
  const std::string text = schema_text();
  const json document = json::parse(schema_json());
  EXPECT_EQ(document["$schema"], "https://json-schema.org/draft/2020-12/schema");
  for (const Table* table : schema::all_tables()) {
    const json& described = table == &schema::root() ? document : document["$defs"][std::string(table->name)];
    EXPECT_EQ(described["properties"].size(), table->keys.size()) << table->name;
    EXPECT_EQ(described["additionalProperties"], false);
    EXPECT_THAT(text, HasSubstr(std::string(table->header)));
    for (const Key& key : table->keys) {
      EXPECT_TRUE(described["properties"].contains(key.name)) << key.name;
      EXPECT_FALSE(key.meaning.empty()) << key.name;
      EXPECT_THAT(text, HasSubstr("\n  " + std::string(key.name) + " "));
    }
  }
  EXPECT_EQ(document["$defs"]["simulation"]["properties"]["horizon"]["default"], 1.87);
  EXPECT_EQ(document["$defs"]["simulation"]["required"], json({"spacing"}));
  EXPECT_EQ(document["$defs"]["materials"]["properties"]["law"]["enum"],
            json({"corotated", "ordinary", "projective", "basis", "stvk", "neo-hookean"}));
  EXPECT_EQ(document["$defs"]["materials"]["properties"]["density"]["anyOf"][0]["exclusiveMinimum"], 0);
  EXPECT_THAT(text, HasSubstr("default 1.87"));
  EXPECT_THAT(text, HasSubstr("number, 0 to 0.95"));
}

} // namespace
} // namespace pliant
