// The keys of a scene file: one table of names, types, units, ranges and meanings, from which the parser's
// known keys, the schema for people and for programs, and run.json are all made, so that they cannot
// disagree.
//
//   Table "simulation" -> Key "spacing" -> slot: where in SimulationSettings its value lives, and so its type
//   and default
//                                       -> or nested: another Table, once, in a list, or under names
#pragma once

#include "engine/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string_view>
#include <variant>

namespace pliant {

/// Every key by table, with units, ranges, defaults and meanings; for people.
std::string schema_text();
/// The same as a JSON Schema, draft 2020-12.
std::string schema_json();

namespace schema {

/// A list of words that each raise a flag, in the order of Key::choices.
struct Flags {
  std::array<bool*, 2> raised;
};

/// Where a value lives. A bool whose key has two choices is false for the first and true for the second.
using Slot = std::variant<bool*, std::optional<bool>*, int*, unsigned*, std::optional<unsigned>*, double*,
                          std::optional<double>*, std::string*, Vector3*, std::optional<Vector3>*, Matrix3*,
                          std::array<unsigned, 2>*, std::array<bool, 3>*,
                          std::optional<std::array<double, 2>>*, std::vector<std::string>*,
                          std::map<std::string, double>*, Flags>; // map: shares of basis functions by name

/// Larger numbers do not fit the single precision of the kernels.
constexpr double largest = 1e30;
/// Nor do smaller ones, but for zero.
constexpr double smallest = 1e-30;
/// A time from here on means "never".
constexpr double never = 1e300;

/// Of a number, or of each component of a vector.
struct Range {
  double low = -largest, high = largest;
  bool above = false, below = false; ///< the limit itself is excluded
  std::string_view why = "";         ///< "because ..."
};

struct Table;

/// A table within a table.
struct Nested {
  enum class How { one, list, named };
  const Table* table = nullptr;
  How how = How::one;
  void* (*add)(void* parent) = nullptr;              ///< the object to fill; of a list a new element
  std::vector<void*> (*all)(void* parent) = nullptr; ///< those that there are
};

struct Key {
  std::string_view name;
  std::string_view meaning;             ///< one line
  Slot (*slot)(void* object) = nullptr; ///< null where nested
  std::string_view unit = "";
  Range range = {};
  std::vector<std::string_view> choices = {};
  std::string_view example = ""; ///< TOML; where there is no default
  bool required = false;
  bool direction = false; ///< a vector that is normalised
  double scale = 1;       ///< stored = typed * scale
  Nested nested = {};
  bool (*applies)(const void* object) = nullptr; ///< whether run.json lists it; null: always
};

struct Table {
  std::string_view name;   ///< of its kind: "simulation", "shape"
  std::string_view header; ///< as typed: "[simulation]"
  std::string_view meaning;
  std::vector<Key> keys;
  std::shared_ptr<void> defaults; ///< an object as it is before anything is read

  const Key* find(std::string_view wanted) const;
};

const Table& root();
const Table& shape_table();
const Table& rotation_table();
const Table& material_table();
const Table& basis_table();
const Table& anisotropy_table();
const Table& plastic_table();
const Table& body_table();
const Table& boundary_table();
const Table& moved_table();
const Table& loaded_table();
const Table& region_table();
const Table& deformed_table();
const Table& fluid_table();
const Table& domain_table();
const Table& emitter_table();
const Table& nozzle_table();
const Table& sink_table();
const Table& simulation_table();
const Table& camera_table();
const Table& render_table();
/// All tables that root() reaches, each once, in order of first mention.
std::vector<const Table*> all_tables();

/// What a key holds in words: "number", "[x, y, z]", "list of strings", ...
std::string type_name(const Key& key, const Table& table);
/// The range in words: "above 0", "0 to 0.499"; empty where there is none.
std::string range_text(const Range& range);
/// The value of a key in an object, in the unit in which it is typed; null where it is not set.
nlohmann::json value_json(const Key& key, void* object);

} // namespace schema
} // namespace pliant
