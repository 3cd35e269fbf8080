// A film from frames, by a pipe into the ffmpeg program.
#pragma once

#include "engine/render/image.h"

#include <filesystem>
#include <string>
#include <sys/types.h>

namespace pliant {

/// Whether an ffmpeg program is there, and the video encoder that it would use: "libx264", "mpeg4", or "" for
/// none.
std::string film_encoder();

/// An MP4 in fragments of about a second, so that what was written stays playable whatever ends the run;
/// ffmpeg outlives a killed run for as long as it needs to finish the file.
class Film {
public:
  /// Starts ffmpeg on a new file; sizes that are odd gain a black row or column, as the pixel format asks.
  /// Throws Error(input_output) where ffmpeg is missing, naming the package, or has no encoder for MP4.
  Film(const std::filesystem::path& path, unsigned width, unsigned height, double fps);
  /// Ends the film in silence.
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  /// Adds a picture of the film's size; RGBA loses its transparency. Throws Error(input_output), with
  /// ffmpeg's own words, where ffmpeg ended or cannot write; the frames before stay in the file.
  void add(const Image& frame);
  /// Ends the film and reports what went wrong.
  void close();

private:
  [[noreturn]] void fail(const std::string& what);
  int end(); ///< closes the pipe, waits, and gives ffmpeg's exit status
  std::string words() const;

  std::filesystem::path path_;
  unsigned width_, height_;
  pid_t process_ = -1;
  int pipe_ = -1, log_ = -1;
};

} // namespace pliant
