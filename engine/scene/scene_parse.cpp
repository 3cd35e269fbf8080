// Scene files: every key of the schema is read into its slot, checked for type and range; faults are
// collected.
#include "engine/scene/scene_parse.h"

#include "engine/core/error.h"
#include "engine/scene/scene_parse_findings.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>

namespace pliant {
namespace {

using schema::Key;
using schema::Nested;
using schema::Table;
using Kind = TomlValue::Kind;

constexpr std::size_t largest_file = 16 << 20; // bytes; a mesh given by mistake should not fill the memory

/// "a/b" or "a", decimal. Empty where it is neither.
std::optional<double> fraction(std::string_view text) {
  const auto number = [](std::string_view part) -> std::optional<double> {
    while (!part.empty() && part.front() == ' ') part.remove_prefix(1);
    while (!part.empty() && part.back() == ' ') part.remove_suffix(1);
    double value = 0;
    const auto [end, failure] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (failure != std::errc{} || end != part.data() + part.size()) return std::nullopt;
    return value;
  };
  const auto slash = text.find('/');
  const auto upper = number(text.substr(0, slash));
  if (slash == std::string_view::npos || !upper) return upper;
  const auto lower = number(text.substr(slash + 1));
  if (!lower || *lower == 0) return std::nullopt;
  return *upper / *lower;
}

class Reader {
public:
  explicit Reader(Findings& findings) : findings_(findings) {}

  void table(const Table& table, const TomlValue& value, void* object, const std::string& path) {
    if (value.kind != Kind::table) {
      wrong_type(value, path, "a table");
      return;
    }
    for (const TomlValue& entry : value.items)
      if (!table.find(entry.key))
        findings_.add(entry.key_where, fmt::format("unknown key {} in {}{}", in_quotes(entry.key),
                                                   path.empty() ? "the scene" : in_quotes(path),
                                                   key_suggestion(entry.key, table)));
    for (const Key& key : table.keys) {
      const std::string key_path =
          path.empty() ? std::string(key.name) : fmt::format("{}.{}", path, key.name);
      const TomlValue* entry = value.find(key.name);
      if (!entry) {
        if (key.required) missing(key, value, path);
      } else if (key.nested.table) {
        nested(key.nested, *entry, object, key_path);
      } else {
        const schema::Slot slot = key.slot(object);
        std::visit([&](auto place) { read(key, *entry, key_path, place); }, slot);
      }
    }
    check_table(table, value, object, path, findings_);
  }

private:
  void nested(const Nested& nested, const TomlValue& value, void* parent, const std::string& path) {
    if (nested.how == Nested::How::one) {
      table(*nested.table, value, nested.add(parent), path);
    } else if (nested.how == Nested::How::list) {
      if (value.kind != Kind::array) {
        wrong_type(value, path, fmt::format("a list of tables, each typed as {}", nested.table->header));
        return;
      }
      for (std::size_t i = 0; i < value.items.size(); ++i)
        table(*nested.table, value.items[i], nested.add(parent), fmt::format("{}.{}", path, i));
    } else {
      if (value.kind != Kind::table) {
        wrong_type(value, path, fmt::format("tables, each typed as {}", nested.table->header));
        return;
      }
      for (const TomlValue& entry : value.items) {
        auto* material = static_cast<Material*>(nested.add(parent));
        material->name = entry.key;
        table(*nested.table, entry, material, fmt::format("{}.{}", path, entry.key));
      }
    }
  }

  void wrong_type(const TomlValue& value, std::string_view path, std::string_view wanted) {
    findings_.add(value.where, fmt::format("{} must be {}, not {}", path, wanted, value.kind_name()));
  }

  void missing(const Key& key, const TomlValue& value, const std::string& path) {
    const std::string where = path.empty() ? "the scene" : path;
    const auto& nested = key.nested;
    std::string what = nested.table && nested.how != Nested::How::one ? std::string(nested.table->header)
                       : nested.table && path.empty()                 ? fmt::format("[{}]", key.name)
                                                                      : in_quotes(key.name);
    if (!key.example.empty()) what += fmt::format(", such as {} = {}", key.name, key.example);
    if (nested.table == &schema::shape_table())
      what += fmt::format(", such as {} = {{ box = [1, 1, 1] }}", key.name);
    findings_.add(value.where, fmt::format("{} lacks {} ({})", where, what, key.meaning));
  }

  /// A finite number within the key's range, in the unit typed.
  std::optional<double> number(const Key& key, const TomlValue& value, const std::string& path) {
    double number = value.number;
    if (value.kind == Kind::text) {
      const auto parsed = fraction(value.text);
      if (!parsed) {
        findings_.add(value.where, fmt::format("{} must be a number{}, not the string {}", path, unit(key),
                                               in_quotes(value.text)));
        return std::nullopt;
      }
      number = *parsed;
    } else if (!value.is_number()) {
      wrong_type(value, path, "a number" + unit(key));
      return std::nullopt;
    }
    const schema::Range& range = key.range;
    if (!std::isfinite(number)) {
      findings_.add(value.where, fmt::format("{} = {} is not finite; type an ordinary number", path, number));
      return std::nullopt;
    }
    const double size = std::abs(number);
    if (size > schema::largest || (number != 0 && size < schema::smallest)) {
      findings_.add(value.where, fmt::format("{} = {} does not fit single precision; stay between {} and {}",
                                             path, number, schema::smallest, schema::largest));
      return std::nullopt;
    }
    if (number < range.low || number > range.high || (range.above && number <= range.low) ||
        (range.below && number >= range.high)) {
      findings_.add(value.where, fmt::format("{} = {} is out of range: it must be {}{}{}{}", path, number,
                                             schema::range_text(range), unit(key),
                                             range.why.empty() ? "" : ", because ", range.why));
      return std::nullopt;
    }
    return number * key.scale;
  }

  static std::string unit(const Key& key) { return key.unit.empty() ? "" : fmt::format(" ({})", key.unit); }

  std::optional<double> whole(const Key& key, const TomlValue& value, const std::string& path) {
    if (!value.is_number() || (std::isfinite(value.number) && value.number != std::floor(value.number))) {
      findings_.add(value.where, fmt::format("{} must be a whole number{}, not {}", path, unit(key),
                                             value.is_number() ? fmt::format("{}", value.number)
                                                               : std::string(value.kind_name())));
      return std::nullopt;
    }
    return number(key, value, path);
  }

  bool is_list(const Key& key, const TomlValue& value, const std::string& path, std::size_t length) {
    const char* wanted = length == 3 ? "a list of three" : "a list of two";
    if (value.kind == Kind::array && value.items.size() == length) return true;
    findings_.add(value.where,
                  fmt::format("{} must be {}{}, not {}", path, wanted, unit(key),
                              value.kind == Kind::array ? fmt::format("a list of {}", value.items.size())
                                                        : std::string(value.kind_name())));
    return false;
  }

  /// The index of a word among the key's choices.
  std::optional<std::size_t> choice(const Key& key, const TomlValue& value, const std::string& path) {
    std::vector<std::string> known;
    for (std::size_t i = 0; i < key.choices.size(); ++i) {
      if (value.kind == Kind::text && key.choices[i] == value.text) return i;
      if (!key.choices[i].empty()) known.emplace_back(key.choices[i]);
    }
    if (value.kind != Kind::text)
      wrong_type(value, path, fmt::format("one of \"{}\"", fmt::join(known, "\", \"")));
    else
      findings_.add(value.where, fmt::format("{} = {} is not known; it must be one of \"{}\"{}", path,
                                             in_quotes(value.text), fmt::join(known, "\", \""),
                                             did_you_mean(value.text, known)));
    return std::nullopt;
  }
  static std::string did_you_mean(std::string_view typed, const std::vector<std::string>& known) {
    const std::string text = suggestion(typed, known);
    return text.find("did you mean") == std::string::npos ? "" : text;
  }

  void read(const Key& key, const TomlValue& value, const std::string& path, double* place) {
    if (const auto n = number(key, value, path)) *place = *n;
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, std::optional<double>* place) {
    if (const auto n = number(key, value, path)) *place = *n;
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, int* place) {
    if (const auto n = whole(key, value, path)) *place = static_cast<int>(*n);
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, unsigned* place) {
    if (const auto n = whole(key, value, path)) *place = static_cast<unsigned>(*n);
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, std::optional<unsigned>* place) {
    if (const auto n = whole(key, value, path)) *place = static_cast<unsigned>(*n);
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, std::array<bool, 3>* place) {
    if (!is_list(key, value, path, 3)) return;
    for (std::size_t i = 0; i < 3; ++i)
      if (value.items[i].kind == Kind::boolean)
        (*place)[i] = value.items[i].boolean;
      else
        wrong_type(value.items[i], fmt::format("{}[{}]", path, i), "true or false");
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, bool* place) {
    if (!key.choices.empty()) {
      if (const auto index = choice(key, value, path)) *place = *index == 1;
    } else if (value.kind == Kind::boolean) {
      *place = value.boolean;
    } else {
      wrong_type(value, path, "true or false");
    }
  }
  void read(const Key&, const TomlValue& value, const std::string& path, std::optional<bool>* place) {
    if (value.kind == Kind::boolean)
      *place = value.boolean;
    else
      wrong_type(value, path, "true or false");
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, std::string* place) {
    if (!key.choices.empty()) {
      if (const auto index = choice(key, value, path)) *place = std::string(key.choices[*index]);
    } else if (value.kind == Kind::text) {
      *place = value.text;
    } else {
      wrong_type(value, path, "a string");
    }
  }
  bool vector(const Key& key, const TomlValue& value, const std::string& path, Vector3& place) {
    if (!is_list(key, value, path, 3)) return false;
    Vector3 read = Vector3::Zero();
    bool good = true;
    for (int i = 0; i < 3; ++i) {
      const auto n = number(key, value.items[static_cast<std::size_t>(i)], fmt::format("{}[{}]", path, i));
      good = good && n;
      if (n) read[i] = *n;
    }
    if (good && key.direction) {
      // Scaled first: the square of the largest number allowed would overflow a float, and the least would
      // vanish.
      const double scale = read.cwiseAbs().maxCoeff();
      if (!(scale > 0)) {
        findings_.add(value.where,
                      fmt::format("{} = [0, 0, 0] has no direction; give one such as [0, 1, 0]", path));
        return false;
      }
      read = (read / scale).normalized();
    }
    if (good) place = read;
    return good;
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, Vector3* place) {
    vector(key, value, path, *place);
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, std::optional<Vector3>* place) {
    if (Vector3 read; vector(key, value, path, read)) *place = read;
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, Matrix3* place) {
    if (!is_list(key, value, path, 3)) return;
    Matrix3 read;
    bool good = true;
    for (int i = 0; i < 3; ++i) {
      Vector3 row;
      const auto index = static_cast<std::size_t>(i);
      good = vector(key, value.items[index], fmt::format("{}[{}]", path, i), row) && good;
      if (good) read.row(i) = row;
    }
    if (good) *place = read;
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, std::array<unsigned, 2>* place) {
    if (!is_list(key, value, path, 2)) return;
    const auto a = whole(key, value.items[0], path + "[0]"), b = whole(key, value.items[1], path + "[1]");
    if (a && b) *place = {static_cast<unsigned>(*a), static_cast<unsigned>(*b)};
  }
  void read(const Key& key, const TomlValue& value, const std::string& path,
            std::optional<std::array<double, 2>>* place) {
    if (!is_list(key, value, path, 2)) return;
    const auto a = number(key, value.items[0], path + "[0]"), b = number(key, value.items[1], path + "[1]");
    if (a && b) *place = {*a, *b};
  }
  /// Indices of the words of a list among the key's choices; faults are reported and left out.
  std::vector<std::size_t> words(const Key& key, const TomlValue& value, const std::string& path) {
    std::vector<std::size_t> indices;
    if (value.kind != Kind::array) {
      wrong_type(value, path, fmt::format("a list of \"{}\"", fmt::join(key.choices, "\", \"")));
      return indices;
    }
    for (std::size_t i = 0; i < value.items.size(); ++i)
      if (const auto index = choice(key, value.items[i], fmt::format("{}[{}]", path, i)))
        indices.push_back(*index);
    return indices;
  }
  void read(const Key& key, const TomlValue& value, const std::string& path,
            std::vector<std::string>* place) {
    std::vector<bool> taken(key.choices.size());
    for (const std::size_t index : words(key, value, path)) {
      if (!taken[index]) place->emplace_back(key.choices[index]);
      taken[index] = true;
    }
  }
  void read(const Key& key, const TomlValue& value, const std::string& path,
            std::map<std::string, double>* place) {
    if (value.kind != Kind::table) {
      wrong_type(value, path, fmt::format("a table of numbers, such as {}", key.example));
      return;
    }
    for (const TomlValue& entry : value.items)
      if (const auto n = number(key, entry, fmt::format("{}.{}", path, entry.key))) (*place)[entry.key] = *n;
  }
  void read(const Key& key, const TomlValue& value, const std::string& path, schema::Flags place) {
    for (const std::size_t index : words(key, value, path)) *place.raised[index] = true;
  }

  Findings& findings_;
};

} // namespace

Scene parse_scene(std::string_view text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides) {
  TomlValue document = parse_toml(text, file);
  Findings findings(file, overrides);
  for (std::size_t i = 0; i < overrides.size(); ++i)
    apply_override(document, overrides[i], static_cast<int>(i), findings);
  Scene scene;
  scene.file = file;
  Reader(findings).table(schema::root(), document, &scene, "");
  check_scene(document, scene, findings);
  findings.raise();
  return scene;
}

Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw Error(ExitCode::usage, file.string() + " is a folder; name the scene file in it");
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw Error(
        ExitCode::usage,
        file.string() +
            ": no such scene file, or it cannot be read; `pliant scenes` lists those that come with it");
  std::string text;
  std::array<char, 4096> block;
  while (stream.read(block.data(), block.size()), stream.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > largest_file)
      throw Error(ExitCode::usage, file.string() + " is larger than 16 MiB; a scene is a short TOML file");
  }
  return parse_scene(text, file, overrides);
}

} // namespace pliant
