// The built program as a user calls it: words in, exit code and both outputs back.
#pragma once

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace pliant::test {

/// A folder that goes away with the test.
class Folder {
public:
  Folder() {
    static std::atomic<int> number{0};
    path_ = std::filesystem::temp_directory_path() /
            ("pliant-program-" + std::to_string(::getpid()) + "-" + std::to_string(number++));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return (path_ / name).string();
  }

private:
  std::filesystem::path path_;
};

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

struct Outcome {
  int code = -1;
  std::string out, err;
};

/// Runs the program in `folder`. `environment`: e.g. "XDG_CACHE_HOME=/nowhere".
inline Outcome pliant(const Folder& folder, const std::vector<std::string>& words,
                      const std::string& environment = "") {
  const auto quoted = [](const std::string& word) {
    std::string text = "'";
    for (char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
  };
  const Folder outputs;
  std::string command =
      "cd " + quoted(folder.path().string()) + " && env " + environment + " " + quoted(PLIANT_PROGRAM);
  for (const std::string& word : words) command += " " + quoted(word);
  command +=
      " </dev/null >" + quoted((outputs / "out").string()) + " 2>" + quoted((outputs / "err").string());
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(outputs / "out"),
          text_of(outputs / "err")};
}

/// A box of 6 x 4 x 4 particles over a floor, held at one end.
inline constexpr const char* small_scene = R"(format = 1
name = "small"
[simulation]
spacing = 0.05
time_step = "1/60"
end = 0.1
[materials.rubber]
density = 1000
young = 1e5
poisson = 0.3
[[body]]
name = "block"
material = "rubber"
shape = { box = [0.3, 0.2, 0.2], at = [0, 0.12, 0] }
[[boundary]]
name = "floor"
shape = { plane = [0, 1, 0], offset = 0 }
[output]
fps = 30
)";

} // namespace pliant::test
