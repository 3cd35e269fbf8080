// TOML text as a plain tree that remembers where each thing was typed. The only door to toml++.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// Where a value was typed: line and column of the file, or the number of a `--set` (from 0).
struct Where {
  int override_index = -1;
  unsigned line = 1, column = 1;
};

/// A TOML value. Entries of a table stand in `items` in the order in which they were typed, each with its
/// `key`.
struct TomlValue {
  enum class Kind { boolean, integer, number, text, date, array, table };
  Kind kind = Kind::table;
  Where where;
  std::string key;
  Where key_where;
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0; ///< also set for integers
  std::string text;
  std::vector<TomlValue> items;

  bool is_number() const { return kind == Kind::integer || kind == Kind::number; }
  /// The entry of that name, or null. Of a table.
  TomlValue* find(std::string_view name);
  const TomlValue* find(std::string_view name) const;
  /// "a string", "an array", ... for messages.
  const char* kind_name() const;
};

/// Parses a document. Throws Error(usage) "file:line:column: ..." where the text is not TOML.
TomlValue parse_toml(std::string_view text, const std::filesystem::path& file);

/// Parses the value of a `--set`: TOML, or a bare word or fraction (1/60), which is taken as a string. Its
/// places bear `override_index`. Returns false where it is neither, with the reason.
bool parse_toml_value(std::string_view text, int override_index, TomlValue& value, std::string& reason);

} // namespace pliant
