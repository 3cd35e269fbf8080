// PNG files, by libpng's simplified interface.
#include "engine/io/png.h"

#include "engine/core/error.h"

#include <fmt/format.h>
#include <png.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace pliant {

namespace {

[[noreturn]] void fail(const char* doing, const std::filesystem::path& path, const std::string& why) {
  throw Error(ExitCode::input_output, fmt::format("cannot {} {}: {}", doing, path.string(), why));
}

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

} // namespace

void write_png(const Image& image, const std::filesystem::path& path) {
  if ((image.channels != 3 && image.channels != 4) || image.width == 0 || image.height == 0 ||
      image.pixels.size() != std::size_t(image.width) * image.height * image.channels)
    throw Error(ExitCode::internal,
                fmt::format("a picture of {} x {} x {} with {} bytes cannot become {}", image.width,
                            image.height, image.channels, image.pixels.size(), path.string()));
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = image.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;

  const std::string draft = path.string() + ".tmp";
  std::FILE* file = std::fopen(draft.c_str(), "wb");
  if (!file) fail("write", path, std::strerror(errno));
  errno = 0;
  const bool packed = png_image_write_to_stdio(&png, file, 0, image.pixels.data(), 0, nullptr) != 0;
  int number = packed ? 0 : errno;
  if (std::fclose(file) != 0 && number == 0) number = errno;
  if (packed && number == 0 && std::rename(draft.c_str(), path.c_str()) != 0) number = errno;
  if (packed && number == 0) return;
  std::remove(draft.c_str());
  fail("write", path, number ? std::strerror(number) : png.message);
}

Image read_png(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, Closer> file(std::fopen(path.c_str(), "rb"));
  if (!file) fail("read", path, std::strerror(errno));
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_stdio(&png, file.get())) fail("read", path, png.message);
  Image image;
  image.channels = png.format & PNG_FORMAT_FLAG_ALPHA ? 4 : 3;
  png.format = image.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  image.width = png.width;
  image.height = png.height;
  image.pixels.resize(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr)) {
    const std::string why = png.message;
    png_image_free(&png);
    fail("read", path, why);
  }
  return image;
}

} // namespace pliant
