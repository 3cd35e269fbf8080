// An axis of a plot: its range, its ticks, and where a value lies.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

struct Tick {
  double value;
  std::string label; ///< empty: a minor one
};

class Axis {
public:
  /// Chooses range and ticks: about `wanted` labelled ones. `low` > `high` means that there are no data.
  /// `room` is the share of the axis left free beyond each end of a range that was not given.
  Axis(bool logarithmic, double low, double high, const std::optional<std::array<double, 2>>& range,
       int wanted, double room);
  const std::vector<Tick>& ticks() const { return ticks_; }
  /// 0 at the lower end of the range, 1 at the upper.
  double place(double value) const;
  bool can_show(double value) const; ///< finite, and positive on a log axis

private:
  void choose_linear(bool fixed, int wanted);
  void choose_log(bool fixed, int wanted);
  bool logarithmic_;
  double low_, high_;
  std::vector<Tick> ticks_;
};

} // namespace pliant
