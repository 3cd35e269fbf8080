// What the sweep found, for people and for programs.
#include "engine/report/stability.h"

#include "engine/io/folder.h"
#include "engine/report/stability_map.h"

#include <cmath>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>

namespace pliant {

namespace {

nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json cell_json(const StabilityCell& cell) {
  return {{"case", cell.name},
          {"young", cell.young},
          {"poisson", cell.poisson},
          {"time_step", cell.time_step},
          {"stiffness_number", number(cell.stiffness_number)},
          {"method", cell.method},
          {"resolved", cell.resolved},
          {"backend", cell.backend},
          {"refused", cell.refused},
          {"finite", cell.finite},
          {"bounded", cell.bounded},
          {"recovered", cell.recovered},
          {"recovery_wanted", cell.recovery_wanted},
          {"strain", number(cell.strain)},
          {"upright", number(cell.upright)},
          {"farthest", number(cell.farthest)},
          {"first_distance", number(cell.first_distance)},
          {"end_distance", number(cell.end_distance)},
          {"energy", number(cell.energy)},
          {"steps", cell.steps},
          {"iterations", cell.iterations},
          {"restarts", cell.restarts},
          {"at_cap", cell.at_cap},
          {"seconds", cell.seconds},
          {"message", cell.message}};
}

nlohmann::json cells_json(const std::vector<StabilityCell>& cells) {
  nlohmann::json array = nlohmann::json::array();
  for (const StabilityCell& cell : cells) array.push_back(cell_json(cell));
  return array;
}

std::string line(const StabilityCell& cell, const char* verdict) {
  return fmt::format("  {:<12} {:<32} {:<10} {:<14} E {:<7.0e} nu {:<6g} h {:<8.2g} {}\n", verdict, cell.name,
                     cell.method, cell.backend, cell.young, cell.poisson, cell.time_step, cell.message);
}

std::string faults(const std::vector<StabilityCell>& cells) {
  std::string text;
  for (const StabilityCell& cell : cells)
    if (!cell.finite) text += line(cell, "NOT FINITE");
  for (const StabilityCell& cell : cells)
    if (cell.finite && !cell.bounded) text += line(cell, "UNBOUNDED");
  for (const StabilityCell& cell : cells)
    if (cell.bounded && !cell.good()) text += line(cell, "unrecovered");
  return text;
}

/// In quotes, as RFC 4180 has it.
std::string csv_text(const std::string& text) {
  std::string quoted = "\"";
  for (char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

struct Sum {
  std::size_t cells = 0, wanted = 0, recovered = 0, at_cap = 0, steps = 0;
  std::uint64_t iterations = 0, restarts = 0;
  double seconds = 0;
};

} // namespace

std::string stability_text(const StabilityReport& report) {
  std::string text = fmt::format("{}: {} particles, {} steps a cell, at most {} iterations a step\n\n",
                                 report.scene, report.particles, report.steps, report.iterations);
  std::map<std::pair<std::string, std::string>, Sum> sums;
  for (const StabilityCell& cell : report.cells) {
    Sum& sum = sums[{cell.method, cell.backend}];
    ++sum.cells;
    sum.wanted += cell.recovery_wanted;
    sum.recovered += cell.recovery_wanted && cell.recovered;
    sum.at_cap += cell.at_cap, sum.steps += cell.steps;
    sum.iterations += cell.iterations, sum.restarts += cell.restarts;
    sum.seconds += cell.seconds;
  }
  text +=
      fmt::format("  {:<10} {:<14} {:>6} {:>18} {:>18} {:>14} {:>10} {:>9}\n", "method", "backend", "cells",
                  "recovered of asked", "iterations a step", "steps at cap", "restarts", "seconds");
  for (const auto& [key, sum] : sums)
    text += fmt::format("  {:<10} {:<14} {:>6} {:>18} {:>18.1f} {:>12.1f} % {:>10} {:>9.1f}\n", key.first,
                        key.second, sum.cells, fmt::format("{} of {}", sum.recovered, sum.wanted),
                        double(sum.iterations) / double(std::max<std::size_t>(sum.steps, 1)),
                        100. * double(sum.at_cap) / double(std::max<std::size_t>(sum.steps, 1)), sum.restarts,
                        sum.seconds);
  const std::string wrong = faults(report.cells);
  if (!wrong.empty()) text += "\n" + wrong;
  if (!report.apart.empty())
    text +=
        fmt::format("\nApart, not in the summary: {} cells\n{}", report.apart.size(), faults(report.apart));
  for (const std::string& left : report.left_out) text += "\nleft out: " + left;
  text +=
      fmt::format("\n{} cells: {} not finite, {} unbounded, {} unrecovered; {} refused, as they should be\n",
                  report.cells.size(), report.non_finite(), report.unbounded(), report.unrecovered(),
                  report.count([](const StabilityCell& cell) { return cell.refused; }));
  return text;
}

std::string stability_csv(const StabilityReport& report) {
  std::string text =
      "case,young,poisson,time_step,stiffness_number,method,resolved,backend,refused,finite,bounded,"
      "recovered,recovery_wanted,strain,upright,farthest,first_distance,end_distance,energy,steps,"
      "iterations,restarts,at_cap,seconds,message\n";
  for (const StabilityCell& c : report.cells)
    text += fmt::format(
        "{},{:g},{:g},{:.6g},{:.4g},{},{},{},{:d},{:d},{:d},{:d},{:d},{:.4g},{:.4g},{:.4g},{:.4g},"
        "{:.4g},{:.4g},{},{},{},{},{:.3f},{}\n",
        csv_text(c.name), c.young, c.poisson, c.time_step, c.stiffness_number, c.method, csv_text(c.resolved),
        c.backend, c.refused, c.finite, c.bounded, c.recovered, c.recovery_wanted, c.strain, c.upright,
        c.farthest, c.first_distance, c.end_distance, c.energy, c.steps, c.iterations, c.restarts, c.at_cap,
        c.seconds, csv_text(c.message));
  return text;
}

nlohmann::json stability_json(const StabilityReport& report) {
  return {{"scene", report.scene},
          {"particles", report.particles},
          {"steps", report.steps},
          {"iteration_cap", report.iterations},
          {"cells", cells_json(report.cells)},
          {"apart", cells_json(report.apart)},
          {"left_out", report.left_out},
          {"summary",
           {{"cells", report.cells.size()},
            {"non_finite", report.non_finite()},
            {"unbounded", report.unbounded()},
            {"unrecovered", report.unrecovered()},
            {"refused", report.count([](const StabilityCell& cell) { return cell.refused; })},
            {"seconds", report.seconds}}}};
}

void write_stability(const StabilityReport& report, const std::filesystem::path& folder) {
  write_text_file(folder / "stability.csv", stability_csv(report));
  write_text_file(folder / "stability.json", stability_json(report).dump(2) + "\n");
  write_stability_map(report, folder);
}

} // namespace pliant
