// Progress of a run on standard error.
#include "engine/report/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace pliant {

namespace {

constexpr double seconds_between_lines = 2; ///< plain lines, so that a log stays readable

unsigned terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

std::string residual_text(double residual) {
  return residual > 0 ? fmt::format("{:.1e}", residual) : "at the floor";
}

} // namespace

std::string clock_text(double seconds) {
  const auto total = static_cast<long>(std::lround(std::max(seconds, 0.0)));
  if (total >= 3600) return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
  return fmt::format("{}:{:02}", total / 60, total % 60);
}

Progress::Progress(const std::string& style, unsigned frames, unsigned first, std::FILE* to)
    : style_(Style::plain), frames_(frames), first_(first), to_(to),
      start_(std::chrono::steady_clock::now()) {
  if (style == "none") style_ = Style::none;
  if (style == "json") style_ = Style::json;
  if (style == "bar" || (style == "auto" && isatty(fileno(to)))) style_ = Style::bar;
}

Progress::~Progress() {
  if (bar_shown_) std::fputc('\n', to_);
}

void Progress::frame(unsigned done, double time, double residual, unsigned iterations) {
  const auto now = std::chrono::steady_clock::now();
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed > 0 ? (done - first_) / elapsed : 0;
  const double left = rate > 0 ? (frames_ - done) / rate : 0;
  const bool last = done == frames_;
  const double pause = std::chrono::duration<double>(now - last_).count();
  switch (style_) {
  case Style::none:
    return;
  case Style::json:
    fmt::print(
        to_,
        "{{\"frame\":{},\"frames\":{},\"time\":{:.6g},\"fps\":{:.4g},\"residual\":{:.3e},\"iterations\":{},"
        "\"seconds_left\":{:.1f}}}\n",
        done, frames_, time, rate, residual, iterations, left);
    break;
  case Style::plain:
    if (!last && done != 0 && pause < seconds_between_lines) return;
    fmt::print(to_, "frame {}/{}  t {:.3f} s  {:.2f} frames/s  residual {}  {} left\n", done, frames_, time,
               rate, residual_text(residual), clock_text(left));
    break;
  case Style::bar: {
    if (!last && pause < 0.1) return;
    const std::string text = fmt::format(" {}/{}  {:.2f} frames/s  residual {}  {} left", done, frames_, rate,
                                         residual_text(residual), clock_text(left));
    const auto room = static_cast<int>(terminal_width()) - static_cast<int>(text.size()) - 3;
    const int width = std::clamp(room, 0, 40);
    const int filled = frames_ ? static_cast<int>(static_cast<double>(width) * done / frames_) : width;
    draw(fmt::format("[{}{}]{}", std::string(static_cast<std::size_t>(filled), '#'),
                     std::string(static_cast<std::size_t>(width - filled), '.'), text));
    break;
  }
  }
  std::fflush(to_);
  last_ = now;
}

void Progress::say(const std::string& line) {
  if (bar_shown_) fmt::print(to_, "\r\033[K");
  bar_shown_ = false;
  fmt::print(to_, "{}\n", line);
  std::fflush(to_);
}

void Progress::draw(const std::string& text) {
  fmt::print(to_, "\r\033[K{}", text);
  bar_shown_ = true;
}

} // namespace pliant
