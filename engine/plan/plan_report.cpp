// Prints the plan.
#include "engine/plan/plan_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace pliant {

namespace {

std::size_t bytes_of(const BufferSpec& buffer, Precision precision) {
  return buffer.count * element_bytes(buffer.type, precision);
}

const char* type_text(Type type) {
  switch (type) {
  case Type::real:
    return "real";
  case Type::real4:
    return "real4";
  case Type::uint:
    return "uint";
  case Type::uint4:
    return "uint4";
  }
  return "";
}

} // namespace

std::string variant_name(const KernelSpec& kernel) {
  std::vector<std::string> options;
  for (const Field& field : kernel.info->fields) {
    if (field.role != Role::option) continue;
    const std::size_t at = options.size();
    options.push_back(fmt::format("{}={}", field.name, at < kernel.options.size() ? kernel.options[at] : 0));
  }
  return options.empty() ? kernel.info->name
                         : fmt::format("{}[{}]", kernel.info->name, fmt::join(options, ","));
}

std::string plan_text(const Plan& plan, Precision precision) {
  std::string text =
      fmt::format("{} particles, {} bonds\n\ncomponents and their kernels\n", plan.particles, plan.bonds);
  for (const std::string& component : plan.used) {
    std::vector<std::string> names;
    for (const KernelSpec& kernel : plan.kernels)
      if (kernel.component == component) names.push_back(variant_name(kernel));
    text += fmt::format("  {:<24}{}\n", component,
                        names.empty() ? "-" : fmt::format("{}", fmt::join(names, " ")));
  }
  text += fmt::format("left out: {}\n",
                      plan.left_out.empty() ? "nothing" : fmt::format("{}", fmt::join(plan.left_out, ", ")));
  text +=
      fmt::format("\n{:<24}{:<24}{:>7}{:>14}{:>16}\n", "buffer", "component", "type", "elements", "bytes");
  for (const BufferSpec& buffer : plan.buffers)
    text += fmt::format("{:<24}{:<24}{:>7}{:>14}{:>16}\n", buffer.name, buffer.component,
                        type_text(buffer.type), buffer.count, bytes_of(buffer, precision));
  text += fmt::format("{:<24}{:<24}{:>7}{:>14}{:>16}\n", "total", "", "", "", plan.bytes(precision));
  text += fmt::format("\n{:.1f} bytes a particle, {:.1f} bytes a bond, in {} precision\n",
                      plan.bytes_per_particle(precision), plan.bytes_per_bond(precision),
                      precision == Precision::double_precision ? "double" : "single");
  return text;
}

nlohmann::json plan_json(const Plan& plan, Precision precision) {
  nlohmann::json kernels = nlohmann::json::array(), buffers = nlohmann::json::array();
  for (const KernelSpec& kernel : plan.kernels)
    if (std::find(kernels.begin(), kernels.end(), kernel.info->name) == kernels.end())
      kernels.push_back(kernel.info->name);
  for (const BufferSpec& buffer : plan.buffers)
    buffers.push_back({{"name", buffer.name}, {"bytes", bytes_of(buffer, precision)}});
  return {{"components", {{"used", plan.used}, {"left_out", plan.left_out}}},
          {"kernels", kernels},
          {"buffers", buffers},
          {"bytes_per_particle", plan.bytes_per_particle(precision)},
          {"bytes_per_bond", plan.bytes_per_bond(precision)}};
}

} // namespace pliant
