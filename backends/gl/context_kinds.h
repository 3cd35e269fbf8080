// Private to the contexts: bookkeeping shared by context.cpp and open.cpp.
#pragma once

#include <string>

namespace pliant::gl {

/// Native handles of contexts that Pliant made, so that guards can tell a host's.
void remember_own(void* native);
void forget_own(void* native);

/// True for names such as "llvmpipe (LLVM 15.0.6, 256 bits)".
bool software_renderer(std::string name);

} // namespace pliant::gl
