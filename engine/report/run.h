// The command `run`: a scene simulated, drawn and stored.
#pragma once

#include "engine/core/error.h"
#include "engine/device/device.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

class Simulation;

struct RunOptions {
  std::filesystem::path scene;
  std::filesystem::path out;          ///< empty: out/<scene name>
  std::vector<std::string> overrides; ///< key=value
  DeviceRequest device;
  std::string solver;             ///< overrides the scene's method where not empty
  std::optional<unsigned> frames; ///< after frame 0; else until the scene's end
  bool video = false, render = true;
  bool resume = false;           ///< go on from the last checkpoint in `out`, where there is one
  std::string progress = "auto"; ///< auto, bar, plain, json, none
  std::string json;              ///< where run.json goes too: a file, "-" for standard output
  std::function<void(Simulation&)> before_step; ///< for tests: may disturb the state
};

/// Writes the run's folder; see README. Throws Error before the first step for anything that can be known
/// then; afterwards what has been computed is kept, whatever happens: a
/// checkpoint every so often, when interrupted, at divergence and at the end.
ExitCode run_scene(const RunOptions& options);

} // namespace pliant
