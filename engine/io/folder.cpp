// The folder of a run, and text files that are never half there.
#include "engine/io/folder.h"

#include "engine/core/error.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <unistd.h>

namespace pliant {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const std::string& doing, const fs::path& path, const std::string& why) {
  throw Error(ExitCode::input_output, fmt::format("cannot {} {}: {}", doing, path.string(), why));
}

} // namespace

void prepare_output_folder(const fs::path& folder) {
  if (folder.empty()) throw Error(ExitCode::usage, "the output folder has no name; give one with --out");
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (fs::exists(status)) {
    if (!fs::is_directory(status)) fail("write to", folder, "it is a file, not a folder; give another --out");
    const fs::directory_iterator first(folder, error);
    if (error) fail("look into", folder, error.message());
    if (first != fs::directory_iterator())
      fail("write to", folder,
           fmt::format("the folder is not empty (it holds {}); give another --out, or remove the "
                       "folder",
                       first->path().filename().string()));
  } else {
    fs::create_directories(folder, error);
    if (error) fail("make the folder", folder, error.message());
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) fail("write to", folder, std::strerror(errno));
}

void write_text_file(const fs::path& path, const std::string& text) {
  std::error_code ignored;
  const fs::file_status there = fs::status(path, ignored);
  // A terminal, a pipe or /dev/null is written into: a rename would put a file in its place.
  const bool direct = fs::exists(there) && !fs::is_regular_file(there);
  const fs::path draft = direct ? path : fs::path(path.string() + ".tmp");
  const int file = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) fail("write", path, std::strerror(errno));
  int failure = 0;
  for (std::size_t done = 0; failure == 0 && done < text.size();) {
    const ssize_t count = ::write(file, text.data() + done, text.size() - done);
    if (count > 0)
      done += static_cast<std::size_t>(count);
    else if (count < 0 && errno != EINTR)
      failure = errno;
  }
  if (::close(file) != 0 && failure == 0) failure = errno;
  if (failure == 0 && !direct && ::rename(draft.c_str(), path.c_str()) != 0) failure = errno;
  if (failure == 0) return;
  if (!direct) ::unlink(draft.c_str());
  fail("write", path, std::strerror(failure));
}

std::string read_text_file(const fs::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file && file.peek() != std::ifstream::traits_type::eof()) text << file.rdbuf();
  if (!file.is_open() || file.bad() || text.bad()) fail("read", path, std::strerror(errno ? errno : EIO));
  return text.str();
}

} // namespace pliant
