// A scene as JSON, for run.json.
#pragma once

#include "engine/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

namespace pliant {

/// The whole scene with its defaults, under the keys of the scene file and in its units. What is not set is
/// null.
nlohmann::json scene_to_json(const Scene& scene);

} // namespace pliant
