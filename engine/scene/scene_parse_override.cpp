// `--set key=value`: a path through the schema, and a value put there before the scene is validated.
#include "engine/scene/scene_parse_findings.h"

#include <fmt/format.h>

#include <charconv>

namespace pliant {
namespace {

using schema::Key;
using schema::Nested;
using Kind = TomlValue::Kind;

/// The parts of a dotted path; quotes keep dots together. Empty where it is malformed.
std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> parts(1);
  char quote = 0;
  for (const char c : path) {
    if (quote != 0 && c == quote)
      quote = 0;
    else if (quote == 0 && (c == '"' || c == '\''))
      quote = c;
    else if (quote == 0 && c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  for (const std::string& part : parts)
    if (part.empty()) return {};
  return quote == 0 ? parts : std::vector<std::string>{};
}

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  return first == std::string_view::npos
             ? ""
             : std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

/// The element of a list of tables with that index or `name`, or null.
TomlValue* element(TomlValue& list, const std::string& wanted) {
  std::size_t index = 0;
  const auto [end, failure] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
  if (failure == std::errc{} && end == wanted.data() + wanted.size())
    return index < list.items.size() ? &list.items[index] : nullptr;
  for (TomlValue& item : list.items)
    if (const TomlValue* name = item.find("name"); name && name->kind == Kind::text && name->text == wanted)
      return &item;
  return nullptr;
}

std::string known_elements(const TomlValue& list) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.items.size(); ++i) {
    const TomlValue* name = list.items[i].find("name");
    names.push_back(name && name->kind == Kind::text ? fmt::format("{} ({})", i, in_quotes(name->text))
                                                     : fmt::format("{}", i));
  }
  return names.empty() ? "the scene has none" : fmt::format("there are {}", fmt::join(names, ", "));
}

/// Puts a value in the place of `target`, keeping its key.
void assign(TomlValue& target, TomlValue value) {
  value.key = target.key;
  value.key_where = target.key_where;
  target = std::move(value);
}

TomlValue& entry(TomlValue& table, const std::string& key, const Where& where) {
  if (TomlValue* found = table.find(key)) return *found;
  TomlValue added;
  added.where = added.key_where = where;
  added.key = key;
  return table.items.emplace_back(std::move(added));
}

} // namespace

void apply_override(TomlValue& document, const std::string& text, int index, Findings& findings) {
  const Where where{index, 1, 1};
  const auto equals = text.find('=');
  const std::string path = trimmed(std::string_view(text).substr(0, equals));
  const std::vector<std::string> parts = split(path);
  if (equals == std::string::npos || parts.empty()) {
    findings.add(where, "must be key=value, such as solver.tolerance=1e-4");
    return;
  }
  TomlValue value;
  std::string reason;
  if (!parse_toml_value(trimmed(std::string_view(text).substr(equals + 1)), index, value, reason)) {
    findings.add(where, fmt::format("the value is not valid TOML: {}", reason));
    return;
  }

  TomlValue* place = &document;
  const schema::Table* table = &schema::root();
  std::string walked;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Key* key = table->find(parts[i]);
    if (!key) {
      findings.add(where, fmt::format("unknown key {} in {}{}", in_quotes(parts[i]),
                                      walked.empty() ? "the scene" : in_quotes(walked),
                                      key_suggestion(parts[i], *table)));
      return;
    }
    if (place->kind != Kind::table) {
      findings.add(where, fmt::format("{} is {}, not a table", walked, place->kind_name()));
      return;
    }
    const Nested& nested = key->nested;
    const bool last = i + 1 == parts.size();
    if (!nested.table && !last) {
      findings.add(where, fmt::format("{} is a value, and has no {} within; set it as a whole",
                                      in_quotes(parts[i]), in_quotes(parts[i + 1])));
      return;
    }
    walked += (walked.empty() ? "" : ".") + parts[i];
    if (last || nested.how == Nested::How::one) {
      place = &entry(*place, parts[i], where);
      if (nested.table) table = nested.table;
      continue;
    }
    // A list or named tables: the next part says which.
    TomlValue* all = place->find(parts[i]);
    const std::string& wanted = parts[++i];
    if (nested.how == Nested::How::named) {
      std::vector<std::string> names;
      if (all)
        for (const TomlValue& item : all->items) names.push_back(item.key);
      place = all ? all->find(wanted) : nullptr;
      if (!place) {
        findings.add(where, fmt::format("no {} in {}{}", in_quotes(wanted), in_quotes(walked),
                                        suggestion(wanted, names)));
        return;
      }
    } else {
      place = all && all->kind == Kind::array ? element(*all, wanted) : nullptr;
      if (!place) {
        findings.add(where, fmt::format("no {} in {}; {}", in_quotes(wanted), in_quotes(walked),
                                        known_elements(all ? *all : TomlValue{})));
        return;
      }
    }
    walked += "." + wanted;
    table = nested.table;
  }
  assign(*place, std::move(value));
}

} // namespace pliant
