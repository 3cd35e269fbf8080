// How long each component took on the device: time stamps in the command stream, read when they have arrived.
#pragma once

#include "backends/gl/context.h"

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace pliant::gl {

class Timer {
public:
  explicit Timer(const Context& context) : context_(context) {}
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  bool measuring() const { return measuring_; }
  void measure(bool on);
  /// Ends the running component and begins another; "" begins none.
  void enter(std::string_view component);
  /// Sums of what has arrived, without waiting; the rest comes with a later call.
  std::vector<Timing> take();
  void release();

private:
  struct Span {
    std::string component;
    unsigned begin, end;
  };
  unsigned stamp();

  const Context& context_;
  bool measuring_ = false;
  std::string component_;
  unsigned begin_ = 0;
  std::deque<Span> spans_;
  std::vector<unsigned> idle_; ///< queries to use again
  std::map<std::string, double> spent_;
};

} // namespace pliant::gl
