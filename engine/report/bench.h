// What `pliant bench` does: ceilings of the machine, every kernel of two bodies, and reference scenes.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace pliant {

struct BenchOptions {
  std::vector<std::string> backends; ///< "openmp", "gl", "gl:N"; empty: all that are usable
  std::vector<std::string>
      sizes;             ///< "beam" (3,000 particles), "bunny" (25,000), "box" (1,000,000); empty: all
  bool quick = false;    ///< without the box unless it is named, fewer repeats
  std::string json_file; ///< results as JSON; empty: none
  std::string baseline;  ///< earlier JSON to compare with; empty: none
  int repeats = 5;       ///< steps measured of each entry, after one that is not
};

/// Prints tables to `out` and writes the JSON. An entry that takes longer than 20 s is stopped and says so;
/// one whose buffers a device refuses prints "does not fit" and the limit. Returns the exit code; throws
/// Error(usage) for a size, backend or baseline that does not exist, Error(input_output) where the JSON
/// cannot be written.
int run_bench(const BenchOptions& options, std::ostream& out);

} // namespace pliant
