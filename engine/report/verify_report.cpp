// What a verification found, for people and for programs.
#include "engine/report/verify.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pliant {

namespace {

std::string pair_text(const VerifyReport::Pair& pair) {
  std::string text = fmt::format("  {:<14} {:<14} {:>5}", pair.a, pair.b, pair.steps);
  for (const FieldDifference& field : pair.fields)
    text +=
        fmt::format("   {} {:.1e} (median {:.1e})", field.name, field.max_relative, field.median_relative);
  return text;
}

std::string agreement_text(const VerifyReport::Kernels& row) {
  std::string text = fmt::format("{} kernels agree", row.compared);
  if (row.ties > 0) text += fmt::format("; {} results fell to the other side of a tie", row.ties);
  return text;
}

std::string hash_text(const VerifyReport::Hashes& row) {
  return fmt::format("  {:<14} {}\n", row.device,
                     row.identical() ? row.first
                                     : fmt::format("{} and {}: DIFFERENT", row.first, row.second));
}

/// Which stretches ended early, and why; nothing where none did.
std::string stretches_text(const VerifyReport::Stretches& s) {
  if (s.shortened == 0) return {};
  return fmt::format(
      "{} of {} stretches are judged before their end, at the soonest after {} step{}: beyond, a "
      "rounding of the start alone\ngrows to more than {:.0e} in double ({:.1e} at the end of one)\n",
      s.shortened, s.count, s.shortest, s.shortest == 1 ? "" : "s", verify_growth, s.growth);
}

nlohmann::json pairs_json(const std::vector<VerifyReport::Pair>& pairs, bool judged) {
  nlohmann::json array = nlohmann::json::array();
  for (const VerifyReport::Pair& pair : pairs) {
    nlohmann::json fields = nlohmann::json::array();
    for (const FieldDifference& field : pair.fields)
      fields.push_back({{"name", field.name},
                        {"max_relative", field.max_relative}, // null where it is not finite
                        {"median_relative", field.median_relative}});
    array.push_back({{"a", pair.a},
                     {"b", pair.b},
                     {"steps", pair.steps},
                     {"stretches", pair.stretches},
                     {"fields", fields}});
    if (judged) array.back()["within"] = pair.within();
  }
  return array;
}

nlohmann::json hashes_json(const std::vector<VerifyReport::Hashes>& rows) {
  nlohmann::json array = nlohmann::json::array();
  for (const VerifyReport::Hashes& row : rows)
    array.push_back(
        {{"device", row.device}, {"hashes", {row.first, row.second}}, {"identical", row.identical()}});
  return array;
}

} // namespace

std::string verify_text(const VerifyReport& r) {
  std::string text =
      fmt::format("scene {}: {} particles, {} bonds; {}\n\n", r.scene, r.particles, r.bonds,
                  r.iterations > 0 ? fmt::format("{} iterations a step", r.iterations)
                                   : fmt::format("each step solved, to a residual of {:.0e} or the floor of "
                                                 "its precision: a line search cut off on its way ends "
                                                 "elsewhere for one rounding",
                                                 verify_tolerance));
  text += fmt::format(
      "Largest differences after stretches from the same state (limit {:.0e}; position by the body's size, "
      "velocity by the largest speed)\n",
      verify_limit);
  for (const VerifyReport::Pair& pair : r.pairs)
    text += fmt::format("{}   {}\n", pair_text(pair), pair.within() ? "good" : "TOO FAR APART");
  text += stretches_text(r.stretches);
  text += "\nAfter all steps without a restart (reported, not judged)\n";
  for (const VerifyReport::Pair& pair : r.unbroken) text += pair_text(pair) + '\n';
  text += fmt::format("\nFrom run to run: {}\n",
                      r.run_to_run_identical() ? "the same bits" : "NOT the same bits");
  for (const VerifyReport::Hashes& row : r.run_to_run) text += hash_text(row);
  text += fmt::format("With 1 thread and with 2: {}\n",
                      r.threads_identical() ? "the same bits" : "NOT the same bits");
  for (const VerifyReport::Hashes& row : r.threads) text += hash_text(row);
  if (!r.kernels.empty()) text += "Kernel by kernel, against the CPU\n";
  for (const VerifyReport::Kernels& row : r.kernels)
    text +=
        fmt::format("  {:<14} {}\n", row.device, row.mismatch.empty() ? agreement_text(row) : row.mismatch);
  for (const std::string& line : r.skipped) text += fmt::format("skipped: {}\n", line);
  text += r.good() ? "\nThe backends agree.\n" : "\nThe backends do NOT agree.\n";
  return text;
}

nlohmann::json verify_json(const VerifyReport& r) {
  nlohmann::json kernels = nlohmann::json::array();
  for (const VerifyReport::Kernels& row : r.kernels)
    kernels.push_back({{"device", row.device},
                       {"compared", row.compared},
                       {"agree", row.mismatch.empty()},
                       {"ties", row.ties},
                       {"mismatch", row.mismatch}});
  return {{"scene", r.scene},
          {"particles", r.particles},
          {"bonds", r.bonds},
          {"iterations", r.iterations},
          {"limit", verify_limit},
          {"pairs", pairs_json(r.pairs, true)},
          {"stretches",
           {{"count", r.stretches.count},
            {"shortened", r.stretches.shortened},
            {"shortest", r.stretches.shortest},
            {"growth", r.stretches.growth}}},
          {"unbroken", pairs_json(r.unbroken, false)},
          {"run_to_run_identical", r.run_to_run_identical()},
          {"run_to_run", hashes_json(r.run_to_run)},
          {"threads_identical", r.threads_identical()},
          {"threads", hashes_json(r.threads)},
          {"kernels", kernels},
          {"skipped", r.skipped},
          {"good", r.good()}};
}

} // namespace pliant
