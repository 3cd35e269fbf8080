// A film from frames, by a pipe into the ffmpeg program.
#include "engine/io/film.h"

#include "engine/core/error.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

extern char** environ;

namespace pliant {

namespace {

// A file without a name, for the words of a program.
int nameless_file() {
  std::string name = (std::getenv("TMPDIR") ? std::getenv("TMPDIR") : "/tmp") + std::string("/pliant-XXXXXX");
  const int file = ::mkostemp(name.data(), O_CLOEXEC);
  if (file >= 0) ::unlink(name.c_str());
  return file;
}

std::string text_of(int file) {
  std::string text(1 << 16, '\0');
  const ssize_t count = file < 0 ? 0 : ::pread(file, text.data(), text.size(), 0);
  text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return text;
}

// Starts ffmpeg with the given ends; in a process group of its own, so that Ctrl-C in the terminal ends the
// run but lets ffmpeg finish the file. Returns errno.
int start(const std::vector<std::string>& arguments, int input, int output, int errors, pid_t& process) {
  std::vector<char*> words;
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  posix_spawn_file_actions_t ends;
  posix_spawn_file_actions_init(&ends);
  if (input >= 0)
    posix_spawn_file_actions_adddup2(&ends, input, 0);
  else
    posix_spawn_file_actions_addopen(&ends, 0, "/dev/null", O_RDONLY, 0);
  for (const int stream : {1, 2}) {
    const int target = stream == 1 ? output : errors;
    if (target >= 0)
      posix_spawn_file_actions_adddup2(&ends, target, stream);
    else
      posix_spawn_file_actions_addopen(&ends, stream, "/dev/null", O_WRONLY, 0);
  }
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  const int status = ::posix_spawnp(&process, words[0], &ends, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&ends);
  return status;
}

int wait_for(pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

} // namespace

std::string film_encoder() {
  const int answer = nameless_file();
  pid_t process = -1;
  std::string found;
  if (start({"ffmpeg", "-hide_banner", "-encoders"}, -1, answer, -1, process) == 0 &&
      wait_for(process) == 0) {
    const std::string text = text_of(answer);
    for (const char* name : {"libx264", "libopenh264", "mpeg4"})
      if (found.empty() && text.find(fmt::format(" {} ", name)) != std::string::npos) found = name;
  }
  if (answer >= 0) ::close(answer);
  return found;
}

Film::Film(const std::filesystem::path& path, unsigned width, unsigned height, double fps)
    : path_(path), width_(width), height_(height) {
  if (width == 0 || height == 0 || !(fps > 0))
    throw Error(ExitCode::internal,
                fmt::format("a film of {} x {} at {} frames a second cannot be", width, height, fps));
  const std::string encoder = film_encoder();
  if (encoder.empty())
    throw Error(
        ExitCode::input_output,
        fmt::format(
            "cannot write {}: no ffmpeg with a video encoder was found; install the package ffmpeg, or "
            "leave out --video (the pictures are written all the same)",
            path.string()));
  std::array<int, 2> ends = {-1, -1};
  // A socket, because send() can be told not to raise SIGPIPE.
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw Error(ExitCode::input_output,
                fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
  log_ = nameless_file();
  std::vector<std::string> words = {"ffmpeg",
                                    "-hide_banner",
                                    "-loglevel",
                                    "error",
                                    "-y",
                                    "-f",
                                    "rawvideo",
                                    "-pixel_format",
                                    "rgb24",
                                    "-video_size",
                                    fmt::format("{}x{}", width, height),
                                    "-framerate",
                                    fmt::format("{}", fps),
                                    "-i",
                                    "pipe:0",
                                    "-an",
                                    "-vf",
                                    "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                    "-c:v",
                                    encoder,
                                    "-pix_fmt",
                                    "yuv420p"};
  const std::vector<std::string> quality = encoder == "libx264"
                                               ? std::vector<std::string>{"-preset", "medium", "-crf", "18"}
                                           : encoder == "mpeg4" ? std::vector<std::string>{"-q:v", "3"}
                                                                : std::vector<std::string>{"-b:v", "8M"};
  words.insert(words.end(), quality.begin(), quality.end());
  const int gap = fps < 1 ? 1 : static_cast<int>(fps + 0.5);
  words.insert(words.end(),
               {"-g", fmt::format("{}", gap), "-movflags", "+frag_keyframe+empty_moov+default_base_moof",
                "-f", "mp4", "file:" + path.string()});
  const int failure = start(words, ends[1], -1, log_, process_);
  ::close(ends[1]);
  pipe_ = ends[0];
  if (failure != 0) {
    process_ = -1;
    end();
    throw Error(ExitCode::input_output,
                fmt::format("cannot start ffmpeg for {}: {}", path.string(), std::strerror(failure)));
  }
}

Film::~Film() {
  end();
  if (log_ >= 0) ::close(log_);
}

int Film::end() {
  if (pipe_ >= 0) ::close(pipe_);
  pipe_ = -1;
  const int status = process_ > 0 ? wait_for(process_) : 0;
  process_ = -1;
  return status;
}

std::string Film::words() const {
  std::string text = text_of(log_);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (char& c : text)
    if (c == '\n') c = ';';
  return text.empty() ? "ffmpeg gave no reason" : text;
}

void Film::fail(const std::string& what) {
  end();
  throw Error(ExitCode::input_output, fmt::format("{} {}: {}", what, path_.string(), words()));
}

void Film::add(const Image& frame) {
  if (pipe_ < 0) throw Error(ExitCode::internal, fmt::format("the film {} is closed", path_.string()));
  if (frame.width != width_ || frame.height != height_ || (frame.channels != 3 && frame.channels != 4))
    throw Error(ExitCode::internal, fmt::format("a picture of {} x {} does not fit the film {} of {} x {}",
                                                frame.width, frame.height, path_.string(), width_, height_));
  const std::uint8_t* bytes = frame.pixels.data();
  std::vector<std::uint8_t> rgb;
  if (frame.channels == 4) {
    rgb.reserve(std::size_t(width_) * height_ * 3);
    for (std::size_t i = 0; i < frame.pixels.size(); i += 4) rgb.insert(rgb.end(), bytes + i, bytes + i + 3);
    bytes = rgb.data();
  }
  const std::size_t size = std::size_t(width_) * height_ * 3;
  for (std::size_t done = 0; done < size;) {
    const ssize_t count = ::send(pipe_, bytes + done, size - done, MSG_NOSIGNAL);
    if (count >= 0)
      done += static_cast<std::size_t>(count);
    else if (errno != EINTR)
      fail("ffmpeg stopped while it wrote");
  }
}

void Film::close() {
  if (pipe_ < 0) return;
  if (end() != 0) fail("ffmpeg could not finish");
}

} // namespace pliant
