// Reads /proc and the control group; other systems than Linux say nothing, and nothing is refused.
#include "engine/core/memory.h"

#include "engine/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sys/resource.h>
#include <unistd.h>

namespace pliant {

namespace {

constexpr double unknown = std::numeric_limits<double>::infinity();

double machine_free() {
  std::ifstream file("/proc/meminfo");
  for (std::string key, rest; file >> key; std::getline(file, rest)) {
    double kibibytes = 0;
    if (key == "MemAvailable:" && file >> kibibytes) return 1024 * kibibytes;
  }
  return unknown;
}

double group_limit() {
  std::ifstream file("/sys/fs/cgroup/memory.max");
  double bytes = 0;
  return file >> bytes ? bytes : unknown; // "max" is no number
}

double address_space_left() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unknown;
  std::ifstream file("/proc/self/statm");
  double pages = 0;
  if (!(file >> pages)) return unknown;
  return std::max(0.0,
                  static_cast<double>(limit.rlim_cur) - pages * static_cast<double>(sysconf(_SC_PAGESIZE)));
}

std::string size_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6) : fmt::format("{:.3g} GB", bytes / 1e9);
}

} // namespace

double available_memory() {
  return std::min({machine_free(), group_limit(), address_space_left()});
}

void require_memory(const std::string& what, double bytes, double available, double spacing) {
  if (bytes <= available) return;
  const double wanted = spacing * std::cbrt(bytes / std::max(available, 1.0));
  const double unit = std::pow(10, std::floor(std::log10(wanted)) - 1);
  throw Error(
      ExitCode::too_large,
      fmt::format(
          "{} about {} of memory, and {} are free; a spacing of {:.2g} m would do instead of {:.2g} m", what,
          size_text(bytes), size_text(available), std::ceil(wanted / unit) * unit, spacing));
}

} // namespace pliant
