// Which libraries the files are written with, for `doctor`.
#pragma once

#include <string>

namespace pliant {

std::string hdf5_version(); ///< of the library that is loaded, e.g. "1.10.8"
std::string png_version();

} // namespace pliant
