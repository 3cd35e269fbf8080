// A run of a baseline, and what is measured of it.
#pragma once

#include "bench/baselines/baseline.h"

#include <filesystem>

namespace pliant::bench {

struct Sample {
  double time = 0;      ///< s
  double tip_depth = 0; ///< m; how far the particles farthest along x have sunk since t = 0, their mean
  double upright = 0;   ///< share of particles with det F > 0
  double distance = 0;  ///< spacings; root mean square, to the rest shape laid on the body best
  double speed = 0;     ///< m/s, root mean square by mass
};

struct Trial {
  std::string method;
  double time_step = 0, stable_step = 0; ///< s; the second infinite where there is no limit
  double cpu_seconds = 0;                ///< of the thread it ran on
  bool diverged = false;                 ///< not finite, or ten body sizes away: the samples end before it
  double diverged_at = 0;
  std::vector<Sample> samples; ///< the first at t = 0
};

/// Share of the stable step that explicit methods take where none is given.
inline constexpr double safe_share = 0.8;

struct TrialSettings {
  double seconds = 1;
  double time_step = 0; ///< s; 0: the scene's, or safe_share of the stable one where that is smaller
  double damping = 0;   ///< 1/s
  double every = 0.02;  ///< s, between samples; at least a step
};

/// Measures a state.
Sample measure(const Model& model, const Baseline& baseline);
Trial run_trial(const std::string& method, const Scene& scene, const Model& model,
                const TrialSettings& settings);
/// method,time_step,time,tip_depth,upright,distance,speed
void write_csv(const std::vector<Trial>& trials, const std::filesystem::path& file);

/// Figures 1 and 4 from the scenes of the folder `examples`: tables to standard output; figure1 and figure4
/// as .csv, .png and .svg into `folder`. `spacing` in m, of the armadillo.
void draw_figures(const std::filesystem::path& examples, const std::filesystem::path& folder, double spacing);

} // namespace pliant::bench
