// Reading a scene file.
#pragma once

#include "engine/scene/scene.h"

#include <string_view>

namespace pliant {

/// Reads and validates a scene. `overrides` are "key=value" as `--set` takes them: a dotted path
/// (solver.tolerance, materials.rubber.young, body.0.velocity or body.armadillo.velocity) and a TOML value, a
/// bare word or a fraction. Throws Error(usage) with at most ten findings, one a line, each after
/// "file:line:column: " (of an override: after "--set key=value: ").
Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
/// The same from text; `file` names it in messages and stands in Scene::file.
Scene parse_scene(std::string_view text, const std::filesystem::path& file,
                  const std::vector<std::string>& overrides = {});

} // namespace pliant
