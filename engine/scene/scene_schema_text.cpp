// The schema of a scene file for people, and for programs.
#include "engine/scene/scene_schema.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pliant {
namespace {

using nlohmann::ordered_json;
using schema::Key;
using schema::Nested;
using schema::Table;

/// What a slot holds, for both outputs.
struct TypeNames {
  bool choices;
  const char* operator()(bool*) const { return choices ? "word" : "true or false"; }
  const char* operator()(std::optional<bool>*) const { return "true or false"; }
  const char* operator()(int*) const { return "whole number"; }
  const char* operator()(unsigned*) const { return "whole number"; }
  const char* operator()(std::optional<unsigned>*) const { return "whole number"; }
  const char* operator()(double*) const { return "number"; }
  const char* operator()(std::optional<double>*) const { return "number"; }
  const char* operator()(std::string*) const { return choices ? "word" : "string"; }
  const char* operator()(Vector3*) const { return "[x, y, z]"; }
  const char* operator()(std::optional<Vector3>*) const { return "[x, y, z]"; }
  const char* operator()(Matrix3*) const { return "three rows of [x, y, z]"; }
  const char* operator()(std::array<unsigned, 2>*) const { return "[a, b]"; }
  const char* operator()(std::array<bool, 3>*) const { return "three of true or false"; }
  const char* operator()(std::optional<std::array<double, 2>>*) const { return "[a, b]"; }
  const char* operator()(std::vector<std::string>*) const { return "list of words"; }
  const char* operator()(std::map<std::string, double>*) const { return "numbers by name"; }
  const char* operator()(schema::Flags) const { return "list of words"; }
};

/// The default as TOML (which agrees with JSON here), or empty.
std::string default_text(const Key& key, const Table& table) {
  if (key.nested.table || !key.example.empty()) return "";
  const nlohmann::json value = schema::value_json(key, table.defaults.get());
  return value.is_null() || (value.is_string() && value.get<std::string>().empty()) ? "" : value.dump();
}

std::string line(const Key& key, const Table& table) {
  std::string text = fmt::format("  {:<17} {}", key.name, schema::type_name(key, table));
  if (!key.unit.empty()) text += fmt::format(", {}", key.unit);
  if (const std::string range = schema::range_text(key.range); !range.empty())
    text += fmt::format(", {}", range);
  if (!key.choices.empty()) {
    std::vector<std::string> words;
    for (const std::string_view word : key.choices)
      if (!word.empty()) words.push_back(fmt::format("\"{}\"", word));
    text += fmt::format(" of {}", fmt::join(words, ", "));
  }
  if (key.required)
    text += "; required";
  else if (const std::string value = default_text(key, table); !value.empty())
    text += fmt::format("; default {}", value);
  return fmt::format("{}\n{:20}{}\n", text, "", key.meaning);
}

ordered_json number_schema(const schema::Range& range, bool whole) {
  ordered_json number = {{"type", whole ? "integer" : "number"}};
  const auto limit = [whole](double value) {
    return whole ? ordered_json(static_cast<long>(value)) : ordered_json(value);
  };
  if (range.low > -schema::largest) number[range.above ? "exclusiveMinimum" : "minimum"] = limit(range.low);
  if (range.high < schema::largest) number[range.below ? "exclusiveMaximum" : "maximum"] = limit(range.high);
  if (whole) return number;
  return {{"anyOf", {number, {{"type", "string"}, {"pattern", R"(^ *[-+.0-9eE]+ *(/ *[-+.0-9eE]+ *)?$)"}}}}};
}

ordered_json list_schema(const ordered_json& items, std::size_t length) {
  return {{"type", "array"}, {"items", items}, {"minItems", length}, {"maxItems", length}};
}

struct TypeSchema {
  const Key& key;
  ordered_json word() const { return {{"enum", key.choices}}; }
  ordered_json operator()(bool*) const {
    return key.choices.empty() ? ordered_json{{"type", "boolean"}} : word();
  }
  ordered_json operator()(std::optional<bool>*) const { return {{"type", "boolean"}}; }
  ordered_json operator()(int*) const { return number_schema(key.range, true); }
  ordered_json operator()(unsigned*) const { return number_schema(key.range, true); }
  ordered_json operator()(std::optional<unsigned>*) const { return number_schema(key.range, true); }
  ordered_json operator()(double*) const { return number_schema(key.range, false); }
  ordered_json operator()(std::optional<double>*) const { return number_schema(key.range, false); }
  ordered_json operator()(std::string*) const {
    return key.choices.empty() ? ordered_json{{"type", "string"}} : word();
  }
  ordered_json operator()(Vector3*) const { return list_schema(number_schema(key.range, false), 3); }
  ordered_json operator()(std::optional<Vector3>*) const {
    return list_schema(number_schema(key.range, false), 3);
  }
  ordered_json operator()(Matrix3*) const {
    return list_schema(list_schema(number_schema(key.range, false), 3), 3);
  }
  ordered_json operator()(std::array<unsigned, 2>*) const {
    return list_schema(number_schema(key.range, true), 2);
  }
  ordered_json operator()(std::array<bool, 3>*) const { return list_schema({{"type", "boolean"}}, 3); }
  ordered_json operator()(std::optional<std::array<double, 2>>*) const {
    return list_schema(number_schema(key.range, false), 2);
  }
  ordered_json operator()(std::vector<std::string>*) const { return {{"type", "array"}, {"items", word()}}; }
  ordered_json operator()(std::map<std::string, double>*) const {
    return {
        {"type", "object"}, {"additionalProperties", number_schema(key.range, false)}, {"minProperties", 1}};
  }
  ordered_json operator()(schema::Flags) const { return {{"type", "array"}, {"items", word()}}; }
};

ordered_json key_schema(const Key& key, const Table& table) {
  ordered_json result;
  if (key.nested.table) {
    const ordered_json reference = {{"$ref", fmt::format("#/$defs/{}", key.nested.table->name)}};
    switch (key.nested.how) {
    case Nested::How::one:
      result = reference;
      break;
    case Nested::How::list:
      result = {{"type", "array"}, {"items", reference}};
      break;
    case Nested::How::named:
      result = {{"type", "object"}, {"additionalProperties", reference}, {"minProperties", 1}};
      break;
    }
    if (key.nested.how == Nested::How::list && key.required) result["minItems"] = 1;
  } else {
    result = std::visit([&](auto place) { return TypeSchema{key}(place); }, key.slot(table.defaults.get()));
  }
  result["description"] =
      key.unit.empty() ? std::string(key.meaning) : fmt::format("{} ({})", key.meaning, key.unit);
  if (!key.nested.table && key.example.empty())
    if (const auto value = schema::value_json(key, table.defaults.get()); !value.is_null())
      result["default"] = ordered_json::parse(value.dump());
  return result;
}

ordered_json table_schema(const Table& table) {
  ordered_json result = {{"type", "object"}, {"description", table.meaning}, {"additionalProperties", false}};
  ordered_json required = ordered_json::array();
  for (const Key& key : table.keys) {
    result["properties"][std::string(key.name)] = key_schema(key, table);
    if (key.required) required.push_back(key.name);
  }
  if (!required.empty()) result["required"] = required;
  if (&table == &schema::shape_table())
    for (const char* kind : {"box", "sphere", "cylinder", "torus", "mesh", "plane"})
      result["oneOf"].push_back({{"required", {kind}}});
  return result;
}

} // namespace

std::string schema::type_name(const Key& key, const Table& table) {
  if (!key.nested.table) return std::visit(TypeNames{!key.choices.empty()}, key.slot(table.defaults.get()));
  if (key.nested.how == Nested::How::list) return "tables";
  return key.nested.how == Nested::How::named ? "tables by name" : "table";
}

std::string schema::range_text(const Range& range) {
  const bool low = range.low > -largest, high = range.high < largest;
  if (low && high && range.low == range.high) return fmt::format("{}", range.low);
  if (low && high && !range.above && !range.below) return fmt::format("{} to {}", range.low, range.high);
  std::string text = low ? fmt::format("{} {}", range.above ? "above" : "at least", range.low) : "";
  if (high) text += fmt::format("{}{} {}", low ? " and " : "", range.below ? "below" : "at most", range.high);
  return text;
}

std::string schema_text() {
  std::string text;
  for (const Table* table : schema::all_tables()) {
    text += fmt::format("{}{}{}\n", text.empty() ? "" : "\n",
                        table->header.empty() ? "" : fmt::format("{}  ", table->header), table->meaning);
    for (const Key& key : table->keys) text += line(key, *table);
  }
  return text;
}

std::string schema_json() {
  ordered_json document = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                           {"title", "Pliant scene"}};
  document.update(table_schema(schema::root()));
  for (const Table* table : schema::all_tables())
    if (table != &schema::root()) document["$defs"][std::string(table->name)] = table_schema(*table);
  return document.dump(2);
}

} // namespace pliant
