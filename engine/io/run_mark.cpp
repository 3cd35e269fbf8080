// Bringing run.vtkhdf back to an earlier moment.
#include "engine/io/run_mark.h"

#include "engine/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace pliant {

namespace {

class Descriptor {
public:
  Descriptor(const std::filesystem::path& path, int flags)
      : path_(path), number_(::open(path.c_str(), flags | O_CLOEXEC)) {
    if (number_ < 0) fail("open");
  }
  ~Descriptor() { ::close(number_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  std::uint64_t size() const {
    struct stat about {};
    if (::fstat(number_, &about) != 0) fail("look at");
    return static_cast<std::uint64_t>(about.st_size);
  }
  void read(std::uint64_t offset, std::uint8_t* bytes, std::uint64_t count) const {
    for (std::uint64_t done = 0; done < count;) {
      const ssize_t got = ::pread(number_, bytes + done, count - done, static_cast<off_t>(offset + done));
      if (got == 0) errno = EIO;
      if (got > 0)
        done += static_cast<std::uint64_t>(got);
      else if (got == 0 || errno != EINTR)
        fail("read");
    }
  }
  void write(std::uint64_t offset, const std::uint8_t* bytes, std::uint64_t count) const {
    for (std::uint64_t done = 0; done < count;) {
      const ssize_t put = ::pwrite(number_, bytes + done, count - done, static_cast<off_t>(offset + done));
      if (put > 0)
        done += static_cast<std::uint64_t>(put);
      else if (put < 0 && errno != EINTR)
        fail("write");
    }
  }
  void shorten(std::uint64_t size) const {
    if (::ftruncate(number_, static_cast<off_t>(size)) != 0) fail("shorten");
  }
  void sync() const {
    if (::fsync(number_) != 0) fail("write");
  }
  [[noreturn]] void fail(const char* doing) const {
    throw Error(ExitCode::input_output,
                fmt::format("cannot {} {}: {}", doing, path_.string(), std::strerror(errno)));
  }

private:
  std::filesystem::path path_;
  int number_;
};

/// Calls visit(offset, bytes) for each gap between bulk pieces.
template <class Visit>
void each_gap(const std::vector<std::array<std::uint64_t, 2>>& bulk, std::uint64_t size, Visit visit) {
  std::uint64_t at = 0;
  for (const auto& [offset, bytes] : bulk) {
    if (offset > at) visit(at, offset - at);
    at = offset + bytes;
  }
  if (size > at) visit(at, size - at);
}

} // namespace

RunMark take_mark(const std::filesystem::path& file, std::vector<std::array<std::uint64_t, 2>> bulk) {
  RunMark mark;
  std::sort(bulk.begin(), bulk.end());
  for (const auto& piece : bulk) {
    if (!mark.bulk.empty() && piece[0] <= mark.bulk.back()[0] + mark.bulk.back()[1])
      mark.bulk.back()[1] =
          std::max(mark.bulk.back()[1], piece[0] + piece[1] - mark.bulk.back()[0]); // the same, or the next
    else
      mark.bulk.push_back(piece);
  }
  const Descriptor source(file, O_RDWR);
  source.sync();
  mark.size = source.size();
  each_gap(mark.bulk, mark.size, [&](std::uint64_t offset, std::uint64_t bytes) {
    mark.rest.resize(mark.rest.size() + bytes);
    source.read(offset, mark.rest.data() + mark.rest.size() - bytes, bytes);
  });
  return mark;
}

void restore_mark(const std::filesystem::path& file, const RunMark& mark) {
  const Descriptor target(file, O_RDWR);
  std::uint64_t rest = 0;
  each_gap(mark.bulk, mark.size, [&](std::uint64_t, std::uint64_t bytes) { rest += bytes; });
  if (target.size() < mark.size || rest != mark.rest.size())
    throw Error(ExitCode::input_output,
                fmt::format("{} is shorter than the checkpoint says: {} bytes, not {}; start the run anew in "
                            "another folder",
                            file.string(), target.size(), mark.size));
  target.shorten(mark.size);
  std::uint64_t used = 0;
  each_gap(mark.bulk, mark.size, [&](std::uint64_t offset, std::uint64_t bytes) {
    target.write(offset, mark.rest.data() + used, bytes);
    used += bytes;
  });
}

} // namespace pliant
