// How much memory this process may still take, so that a scene that cannot fit is refused before the system
// ends it.
#pragma once

#include <string>

namespace pliant {

/// Bytes: the least of what the machine has free, its control group allows (cgroup 2), and `ulimit -v`
/// leaves. Infinite where none of them can be read.
double available_memory();

/// Throws Error(too_large) where `bytes` are more than `available`, with both, and with the spacing that
/// would do: `spacing`, m, is the present one, and memory goes with its inverse cube. `what` begins the
/// message.
void require_memory(const std::string& what, double bytes, double available, double spacing);

} // namespace pliant
