// Which names a shader text uses once its #if lines are resolved. A variant declares only the buffers that it
// uses: drivers differ in what they report as used (Mesa calls every declared block active).
#pragma once

#include <map>
#include <set>
#include <string>

namespace pliant::gl {

/// The identifiers in the live part of `text`. `macros` are the names defined before it, by value. A
/// condition that cannot be decided here keeps all its branches, so a name may be given too many, never too
/// few.
std::set<std::string> names_used(const std::string& text, std::map<std::string, std::string> macros);

} // namespace pliant::gl
