// PNG files: 8-bit RGB and RGBA.
#pragma once

#include "engine/render/image.h"

#include <filesystem>

namespace pliant {

/// Writes a picture of 3 or 4 channels, in one rename. Throws Error(input_output).
void write_png(const Image& image, const std::filesystem::path& path);
/// Reads any PNG as 3 channels, or as 4 where it has transparency. Throws Error(input_output).
Image read_png(const std::filesystem::path& path);

} // namespace pliant
