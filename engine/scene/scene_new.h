// Scenes to start from.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// The kinds that new_scene_text() knows, each with a line about it.
std::vector<std::pair<std::string, std::string>> new_scene_kinds();
/// A commented scene of that kind, which needs no mesh. Throws Error(usage) naming the kinds.
std::string new_scene_text(std::string_view kind);

} // namespace pliant
