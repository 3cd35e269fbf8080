// Versions as the loaded libraries say them.
#include "engine/io/library_versions.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <png.h>

namespace pliant {

std::string hdf5_version() {
  unsigned major = 0, minor = 0, release = 0;
  if (H5get_libversion(&major, &minor, &release) < 0) return "unknown";
  return fmt::format("{}.{}.{}", major, minor, release);
}

std::string png_version() {
  return png_get_libpng_ver(nullptr);
}

} // namespace pliant
