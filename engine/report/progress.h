// Progress of a run on standard error: a bar on a terminal, plain lines elsewhere, JSON lines for programs.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace pliant {

class Progress {
public:
  /// `style`: auto, bar, plain, json or none.
  /// `first`: frames that were there before; they count as done, but not for the rate.
  Progress(const std::string& style, unsigned frames, unsigned first = 0, std::FILE* to = stderr);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// After each frame. `residual` is the last step's, relative, 0 at the floor of the precision; `time` the
  /// simulated time, s.
  void frame(unsigned done, double time, double residual, unsigned iterations);
  /// A line that must not be lost in the bar.
  void say(const std::string& line);

private:
  void draw(const std::string& text);

  enum class Style { bar, plain, json, none } style_;
  unsigned frames_, first_;
  std::FILE* to_;
  std::chrono::steady_clock::time_point start_, last_;
  bool bar_shown_ = false;
};

/// "1:02:03" or "0:42".
std::string clock_text(double seconds);

} // namespace pliant
