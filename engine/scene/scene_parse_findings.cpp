// Faults of a scene file: their order, their wording, and the nearest known name.
#include "engine/scene/scene_parse_findings.h"

#include "engine/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

namespace pliant {
namespace {

constexpr std::size_t reported = 10;
constexpr std::size_t longest_quote = 60;

/// Insertions, deletions, substitutions and swaps of neighbours that turn a into b (optimal string
/// alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

/// The nearest of `known`, or empty where none is near.
std::string nearest(std::string_view typed, const std::vector<std::string>& known) {
  if (typed.size() > longest_quote) return "";
  std::string best;
  std::size_t least = std::max<std::size_t>(2, typed.size() / 3) + 1;
  for (const std::string& name : known) {
    std::size_t distance = edit_distance(typed, name);
    const std::size_t shared = std::min(typed.size(), name.size());
    if (shared >= 3 && typed.substr(0, shared) == std::string_view(name).substr(0, shared))
      distance = std::min<std::size_t>(distance, 1);
    if (distance < least) {
      least = distance;
      best = name;
    }
  }
  return least < std::max(typed.size(), best.size()) ? best : "";
}

} // namespace

void Findings::raise() {
  if (found_.empty()) return;
  std::stable_sort(found_.begin(), found_.end(), [](const Finding& a, const Finding& b) {
    return std::tie(a.where.override_index, a.where.line, a.where.column) <
           std::tie(b.where.override_index, b.where.line, b.where.column);
  });
  std::string text;
  for (std::size_t i = 0; i < std::min(found_.size(), reported); ++i) {
    const auto& [where, message] = found_[i];
    if (i > 0) text += '\n';
    if (where.override_index >= 0)
      text +=
          fmt::format("--set {}: {}", overrides_[static_cast<std::size_t>(where.override_index)], message);
    else
      text += fmt::format("{}:{}:{}: {}", file_.string(), where.line, where.column, message);
  }
  if (found_.size() > reported) text += fmt::format("\nand {} more", found_.size() - reported);
  throw Error(ExitCode::usage, text);
}

std::string in_quotes(std::string_view text) {
  std::string shown;
  for (const char c : text.substr(0, longest_quote)) shown += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  return fmt::format("'{}{}'", shown, text.size() > longest_quote ? "..." : "");
}

std::string suggestion(std::string_view typed, const std::vector<std::string>& known) {
  if (const std::string near = nearest(typed, known); !near.empty())
    return fmt::format("; did you mean '{}'?", near);
  return known.empty() ? "" : fmt::format("; known: {}", fmt::join(known, ", "));
}

std::string key_suggestion(std::string_view typed, const schema::Table& table) {
  std::vector<std::string> known;
  for (const schema::Key& key : table.keys) known.emplace_back(key.name);
  if (const std::string near = nearest(typed, known); !near.empty())
    return fmt::format("; did you mean '{}'?", near);
  for (const schema::Table* other : schema::all_tables())
    if (other != &table && other->find(typed) && !other->header.empty())
      return fmt::format("; '{}' is a key of {}; known here: {}", typed, other->header,
                         fmt::join(known, ", "));
  return fmt::format("; known: {}", fmt::join(known, ", "));
}

} // namespace pliant
