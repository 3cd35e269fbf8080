// Error against run time over a whole run: what a tolerance and a time step cost, and what they buy.
//
//   total error   rms distance at the end to a run with an eighth of the scene's step, solved tightly
//   solver error  ... to the tight run of the same step: what the tolerance leaves
//   time error    of the tight run of a step: what the step leaves
//   space error   between the tight run and one with half the spacing, where both have matter
// A total is all of these; iterations that bring the solver error far below the others are wasted.
#pragma once

#include "engine/device/device.h"
#include "engine/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

struct CurveOptions {
  std::optional<unsigned> frames; ///< else as many as the time allows
  double total_seconds = 510;
  DeviceRequest device = {"openmp"}; ///< of the runs that are timed; references run in double on the CPU
  /// Lines of progress.
  std::function<void(const std::string&)> say = [](const std::string&) {};
};

/// One run.
struct CurvePoint {
  double time_step = 0;        ///< s
  double tolerance = 0;        ///< 0 where a budget was given
  unsigned budget = 0;         ///< iterations of every step; 0 where a tolerance was given
  double iterations = 0;       ///< of a step, median
  double ms = 0, ms_worst = 0; ///< a frame: median, 95 % of frames below
  double solver_error = 0, total_error = 0, total_max = 0; ///< spacings: rms, rms, largest
};

struct CurveReport {
  std::string scene, method, device, precision;
  unsigned threads = 1;
  std::size_t particles = 0, bonds = 0;
  double stiffness_number = 0, spacing = 0, time_step = 0; ///< of the scene's step; m; s
  unsigned frames = 0;
  double duration = 0;       ///< s, simulated
  double reference_step = 0; ///< s
  struct Step {
    double time_step = 0, time_error = 0; ///< s, spacings
    double ms = 0;                        ///< of a frame, of the tight run in double
  };
  std::vector<Step> steps;
  std::optional<double> space_error; ///< spacings
  std::string space_note;            ///< why it is missing, or how it was measured
  std::vector<CurvePoint> points;
  /// Iterations of a step of the scene's own length beyond which the solver error is the smaller part.
  std::optional<unsigned> enough;
  std::optional<std::size_t> pick; ///< index of the point to recommend
  std::vector<std::string> left_out;
  double seconds = 0;

  double time_error() const; ///< of the scene's step
};

/// Throws Error(usage): no particles, no frames; Error(diverged): the reference was lost.
CurveReport work_precision(const Scene& scene, const CurveOptions& options);

std::string curve_text(const CurveReport& report);
nlohmann::json curve_json(const CurveReport& report);
std::string curve_csv(const CurveReport& report);
/// converge-run.csv, .json, .svg and .png; returns the paths. Throws Error(input_output).
std::vector<std::filesystem::path> write_curve(const CurveReport& report,
                                               const std::filesystem::path& folder);

} // namespace pliant
