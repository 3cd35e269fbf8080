// The shader files, embedded at build time: name below shaders/ to text.
#pragma once

#include <map>
#include <string>

namespace pliant::gl {

const std::map<std::string, std::string>& shader_texts();

} // namespace pliant::gl
