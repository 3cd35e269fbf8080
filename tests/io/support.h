// A folder for a test's files, and programs run beside it.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <unistd.h>

namespace pliant::test {

/// An empty folder, removed with all that is in it.
class ScratchFolder {
public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "pliant-io-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("no folder for the test");
    path = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path path;
};

struct Answer {
  int status = -1;
  std::string text; ///< both streams
};

inline Answer run_program(const std::string& command) {
  Answer answer;
  std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return answer;
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe)) answer.text += buffer;
  const int status = ::pclose(pipe);
  answer.status = status >= 0 && (status & 0x7f) == 0 ? (status >> 8) & 0xff : -1;
  return answer;
}

inline Answer check_run(const std::filesystem::path& folder, int frames) {
  return run_program("/usr/bin/python3 '" PLIANT_SOURCE_DIR "/tests/readers/check_run.py' '" +
                     folder.string() + "' " + std::to_string(frames));
}

} // namespace pliant::test
