// The command `run`: a scene simulated, drawn and stored.
#pragma once

#include "engine/core/error.h"
#include "engine/device/device.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

struct RunOptions {
  std::filesystem::path scene;
  std::filesystem::path out;          ///< empty: out/<scene name>
  std::vector<std::string> overrides; ///< key=value
  DeviceRequest device;
  std::string solver;             ///< overrides the scene's method where not empty
  std::optional<unsigned> frames; ///< after frame 0; else until the scene's end
  bool video = false, render = true;
  std::string progress = "auto"; ///< auto, bar, plain, json, none
  std::string json;              ///< where run.json goes too: a file, "-" for standard output
};

/// Writes the run's folder; see README. Throws Error before the first step for anything that can be known
/// then; afterwards what has been computed is kept, whatever happens.
ExitCode run_scene(const RunOptions& options);

} // namespace pliant
