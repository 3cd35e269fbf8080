// TOML text to a plain tree, through toml++.
#include "engine/scene/toml_reader.h"

#include "engine/core/error.h"

// toml++ 3.3 asserts that some bad input ("[=") cannot be, and where NDEBUG is set assumes it, which is
// undefined. Here its assertions throw, in every build. No other file may include it, or the two would
// differ.
namespace {
struct Malformed {};
constexpr void hold(bool expected) {
  if (!expected) throw Malformed{};
}
} // namespace
#undef NDEBUG
#define TOML_ASSERT(expression) hold(static_cast<bool>(expression))
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

using Kind = TomlValue::Kind;

Where where_of(const toml::source_region& region, int override_index) {
  // Implicit tables ([materials.rubber] makes `materials`) may have no place of their own: line 0.
  return {override_index, std::max(1u, static_cast<unsigned>(region.begin.line)),
          std::max(1u, static_cast<unsigned>(region.begin.column))};
}

TomlValue convert(const toml::node& node, int override_index) {
  TomlValue value;
  value.where = where_of(node.source(), override_index);
  switch (node.type()) {
  case toml::node_type::table:
    for (auto&& [key, child] : *node.as_table()) {
      TomlValue entry = convert(child, override_index);
      entry.key = std::string(key.str());
      entry.key_where = where_of(key.source(), override_index);
      value.items.push_back(std::move(entry));
    }
    std::stable_sort(value.items.begin(), value.items.end(), [](const TomlValue& a, const TomlValue& b) {
      return std::tie(a.key_where.line, a.key_where.column) < std::tie(b.key_where.line, b.key_where.column);
    });
    break;
  case toml::node_type::array:
    value.kind = Kind::array;
    for (auto&& child : *node.as_array()) value.items.push_back(convert(child, override_index));
    break;
  case toml::node_type::string:
    value.kind = Kind::text;
    value.text = node.as_string()->get();
    break;
  case toml::node_type::integer:
    value.kind = Kind::integer;
    value.integer = node.as_integer()->get();
    value.number = static_cast<double>(value.integer);
    break;
  case toml::node_type::floating_point:
    value.kind = Kind::number;
    value.number = node.as_floating_point()->get();
    break;
  case toml::node_type::boolean:
    value.kind = Kind::boolean;
    value.boolean = node.as_boolean()->get();
    break;
  default:
    value.kind = Kind::date;
  }
  return value;
}

/// One line, printable: what the parser quotes may hold anything.
std::string one_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    if (!control)
      line += c;
    else if (line.empty() || line.back() != ' ')
      line += ' ';
  }
  return line;
}

bool is_malformed(std::string_view text) {
  try {
    static_cast<void>(toml::parse(text));
  } catch (const Malformed&) {
    return true;
  } catch (const toml::parse_error&) {
  }
  return false;
}

/// The end of the shortest malformed beginning of a malformed text: the parser reads forwards, so all longer
/// ones are.
Where malformed_place(std::string_view text) {
  std::size_t good = 0, bad = text.size();
  while (bad - good > 1) {
    const std::size_t middle = good + (bad - good) / 2;
    (is_malformed(text.substr(0, middle)) ? bad : good) = middle;
  }
  Where where;
  for (const char c : text.substr(0, good)) {
    where.column = c == '\n' ? 1 : where.column + 1;
    if (c == '\n') ++where.line;
  }
  return where;
}

bool is_bare(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '.' || c == '/' || c == '+';
  });
}

} // namespace

TomlValue* TomlValue::find(std::string_view name) {
  if (kind != Kind::table) return nullptr;
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const TomlValue& v) { return v.key == name; });
  return found == items.end() ? nullptr : &*found;
}

const TomlValue* TomlValue::find(std::string_view name) const {
  return const_cast<TomlValue*>(this)->find(name);
}

const char* TomlValue::kind_name() const {
  switch (kind) {
  case Kind::boolean:
    return "true or false";
  case Kind::integer:
    return "an integer";
  case Kind::number:
    return "a number";
  case Kind::text:
    return "a string";
  case Kind::date:
    return "a date or time";
  case Kind::array:
    return "an array";
  case Kind::table:
    return "a table";
  }
  return "";
}

TomlValue parse_toml(std::string_view text, const std::filesystem::path& file) {
  Where where;
  std::string reason;
  try {
    return convert(toml::parse(text, file.string()), -1);
  } catch (const toml::parse_error& error) {
    where = where_of(error.source(), -1);
    reason = one_line(error.description());
  } catch (const Malformed&) {
    where = malformed_place(text);
    reason = "unexpected character";
  }
  throw Error(ExitCode::usage, file.string() + ":" + std::to_string(where.line) + ":" +
                                   std::to_string(where.column) + ": not valid TOML: " + reason);
}

bool parse_toml_value(std::string_view text, int override_index, TomlValue& value, std::string& reason) {
  const std::string line = "value = " + std::string(text);
  try {
    const toml::table table = toml::parse(line);
    if (table.size() != 1) {
      reason = "more than one value";
      return false;
    }
    value = convert(*table.get("value"), override_index);
    return true;
  } catch (const toml::parse_error& error) {
    reason = one_line(error.description());
  } catch (const Malformed&) {
    reason = "unexpected character";
  }
  if (!is_bare(text)) return false;
  value = TomlValue{};
  value.kind = Kind::text;
  value.where.override_index = override_index;
  value.text = std::string(text);
  return true;
}

} // namespace pliant
