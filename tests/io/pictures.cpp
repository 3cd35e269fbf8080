// PNG files and films: written, read back by others, and broken on purpose.
#include "engine/core/error.h"
#include "engine/io/film.h"
#include "engine/io/folder.h"
#include "engine/io/png.h"
#include "tests/io/support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sys/wait.h>

using namespace pliant;
using pliant::test::run_program;
using pliant::test::ScratchFolder;
using testing::HasSubstr;

namespace {

Image gradient(unsigned width, unsigned height, unsigned channels, unsigned shift) {
  Image image(width, height, {0, 0, 0}, channels);
  for (unsigned y = 0; y < height; ++y)
    for (unsigned x = 0; x < width; ++x)
      for (unsigned c = 0; c < channels; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(3 * x + 5 * y + 40 * c + 7 * shift);
  return image;
}

bool have_ffprobe() {
  return !film_encoder().empty() && run_program("command -v ffprobe").status == 0;
}

std::string frames_in(const std::filesystem::path& film) {
  return run_program("ffprobe -v error -count_frames -select_streams v -show_entries "
                     "stream=width,height,pix_fmt,nb_read_frames,r_frame_rate -of csv=p=0 '" +
                     film.string() + "'")
      .text;
}

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input_output);
    return error.what();
  }
  return "nothing was thrown";
}

} // namespace

TEST(Png, ReadsBackWhatItWrote) {
  ScratchFolder folder;
  for (const unsigned channels : {3u, 4u}) {
    const Image image = gradient(37, 21, channels, 1);
    write_png(image, folder.path / "a.png");
    const Image back = read_png(folder.path / "a.png");
    EXPECT_EQ(back.width, 37u);
    EXPECT_EQ(back.height, 21u);
    EXPECT_EQ(back.channels, channels);
    EXPECT_EQ(back.pixels, image.pixels);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path / "a.png.tmp"));
}

TEST(Png, FailuresNameTheFile) {
  ScratchFolder folder;
  const Image image = gradient(4, 4, 3, 0);
  EXPECT_THAT(message_of([&] { write_png(image, folder.path / "no" / "a.png"); }), HasSubstr("No such file"));
  EXPECT_THAT(message_of([&] { read_png(folder.path / "missing.png"); }),
              HasSubstr("missing.png: No such file"));
  std::ofstream(folder.path / "false.png") << "this is not a picture at all";
  EXPECT_THAT(message_of([&] { read_png(folder.path / "false.png"); }), HasSubstr("false.png"));
  write_png(gradient(64, 64, 3, 0), folder.path / "cut.png");
  std::filesystem::resize_file(folder.path / "cut.png", 100);
  EXPECT_THAT(message_of([&] { read_png(folder.path / "cut.png"); }), HasSubstr("cut.png"));
  Image wrong = image;
  wrong.pixels.pop_back();
  EXPECT_THROW(write_png(wrong, folder.path / "a.png"), Error);
}

TEST(Film, HoldsEveryFrameAtItsRate) {
  if (!have_ffprobe()) GTEST_SKIP() << "ffmpeg is not installed";
  ScratchFolder folder;
  const auto path = folder.path / "-odd film.mp4"; // a name that could be taken for an option
  Film film(path, 63, 48, 24);
  for (unsigned k = 0; k < 30; ++k) film.add(gradient(63, 48, k % 2 ? 3 : 4, k));
  film.close();
  EXPECT_THAT(frames_in(path), HasSubstr("64,48,yuv420p,24/1,30"));
  EXPECT_THROW(film.add(gradient(63, 48, 3, 0)), Error);
}

TEST(Film, FramesOfAnotherSizeAreRefused) {
  if (!have_ffprobe()) GTEST_SKIP() << "ffmpeg is not installed";
  ScratchFolder folder;
  Film film(folder.path / "film.mp4", 32, 32, 30);
  EXPECT_THROW(film.add(gradient(32, 31, 3, 0)), Error);
}

TEST(Film, MissingFfmpegNamesThePackage) {
  ScratchFolder folder;
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.path.c_str(), 1);
  EXPECT_EQ(film_encoder(), "");
  const std::string said = message_of([&] { Film(folder.path / "film.mp4", 32, 32, 30); });
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(said, HasSubstr("install the package ffmpeg"));
}

// A stand-in for ffmpeg that lists an encoder, takes a little, and ends: the pipe breaks, the program must
// not.
TEST(Film, ABrokenPipeIsAnErrorWithFfmpegsOwnWords) {
  ScratchFolder folder;
  std::ofstream(folder.path / "ffmpeg")
      << "#!/bin/sh\ncase \"$*\" in *-encoders*) echo ' V.. mpeg4 x';; "
         "*) head -c 100 > /dev/null; echo 'no room for the film' >&2; exit 1;; esac\n";
  std::filesystem::permissions(folder.path / "ffmpeg", std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (folder.path.string() + ":" + path).c_str(), 1);
  const std::string said = message_of([&] {
    Film film(folder.path / "film.mp4", 320, 240, 30);
    for (unsigned k = 0; k < 100; ++k) film.add(gradient(320, 240, 3, k));
  });
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(said, HasSubstr("film.mp4: no room for the film"));
}

TEST(Film, AnUnwritablePlaceIsAnError) {
  if (!have_ffprobe()) GTEST_SKIP() << "ffmpeg is not installed";
  const std::string said = message_of([&] {
    Film film("/nowhere/at/all/film.mp4", 64, 64, 30);
    for (unsigned k = 0; k < 100; ++k) film.add(gradient(64, 64, 3, k));
    film.close();
  });
  EXPECT_THAT(said, HasSubstr("No such file or directory"));
}

TEST(Film, AKilledRunLeavesAFilm) {
  if (!have_ffprobe()) GTEST_SKIP() << "ffmpeg is not installed";
  ScratchFolder folder;
  const auto path = folder.path / "film.mp4";
  const pid_t child = ::fork();
  if (child == 0) {
    Film film(path, 64, 64, 10);
    for (unsigned k = 0; k < 25; ++k) film.add(gradient(64, 64, 3, k));
    ::raise(SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status));
  // ffmpeg sees the end of its input and finishes by itself, soon.
  std::string seen;
  for (int tries = 0; tries < 50 && seen.find(",25") == std::string::npos; ++tries) {
    ::usleep(100000);
    seen = frames_in(path);
  }
  EXPECT_THAT(seen, HasSubstr("64,64,yuv420p,10/1,25"));
}
