// An axis of a plot: its range, its ticks, and where a value lies.
#include "engine/render/plot_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

// "1.5e-07" with the zero and the plus taken out of its exponent.
std::string scientific(double value, int digits) {
  std::string text = fmt::format("{:.{}e}", value, digits);
  const auto e = text.find('e');
  int exponent = std::stoi(text.substr(e + 1));
  return exponent == 0 ? text.substr(0, e) : text.substr(0, e) + "e" + std::to_string(exponent);
}

double power(int exponent) {
  return std::pow(10.0, exponent);
}

} // namespace

Axis::Axis(bool logarithmic, double low, double high, const std::optional<std::array<double, 2>>& range,
           int wanted, double room)
    : logarithmic_(logarithmic), low_(low), high_(high) {
  const bool fixed = range && (*range)[0] < (*range)[1] && (!logarithmic || (*range)[0] > 0);
  if (fixed) low_ = (*range)[0], high_ = (*range)[1];
  if (low_ > high_) low_ = logarithmic ? 0.1 : 0, high_ = logarithmic ? 10 : 1;
  if (logarithmic)
    choose_log(fixed, std::max(wanted, 2));
  else
    choose_linear(fixed, std::max(wanted, 2));
  if (fixed || room <= 0) return;
  const double share = room / (1 - 2 * room);
  const double beyond = logarithmic ? std::pow(high_ / low_, share) : (high_ - low_) * share;
  low_ = logarithmic ? low_ / beyond : low_ - beyond;
  high_ = logarithmic ? high_ * beyond : high_ + beyond;
}

void Axis::choose_linear(bool fixed, int wanted) {
  const double size = std::max(std::abs(low_), std::abs(high_));
  // A constant, or what differs only by rounding, gets room on both sides.
  if (high_ - low_ <= 1e-9 * size || size == 0) {
    const double room = size > 0 ? 0.1 * size : 1;
    low_ -= room, high_ += room;
  }
  const double rough = (high_ - low_) / wanted, unit = power(static_cast<int>(std::floor(std::log10(rough))));
  const double share = rough / unit;
  const int lead = share <= 1.0001 ? 1 : share <= 2.0001 ? 2 : share <= 5.0001 ? 5 : 10;
  const double step = lead * unit;
  if (!fixed) low_ = std::floor(low_ / step + 1e-9) * step, high_ = std::ceil(high_ / step - 1e-9) * step;

  const int exponent = static_cast<int>(std::floor(std::log10(step) + 1e-9));
  const int parts = lead == 2 ? 4 : 5;
  const double minor = step / parts;
  const auto first = static_cast<long long>(std::ceil(low_ / minor - 1e-6));
  const auto last = static_cast<long long>(std::floor(high_ / minor + 1e-6));
  // Written out or with an exponent, whichever is shorter for the longest label.
  std::array<std::size_t, 2> longest = {0, 0};
  std::vector<std::array<std::string, 2>> labels;
  for (long long i = first; i <= last; ++i) {
    ticks_.push_back({static_cast<double>(i) * minor, ""});
    labels.emplace_back();
    if (i % parts != 0) continue;
    const double value = static_cast<double>(i / parts) * step;
    const int digits =
        value == 0 ? 0 : static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9)) - exponent;
    ticks_.back().value = value;
    labels.back() = {fmt::format("{:.{}f}", value, std::max(-exponent, 0)),
                     scientific(value, std::max(digits, 0))};
    if (value == 0) labels.back() = {"0", "0"};
    for (int form : {0, 1}) longest[form] = std::max(longest[form], labels.back()[form].size());
  }
  const int form = longest[0] > longest[1] + 1;
  for (std::size_t i = 0; i < ticks_.size(); ++i) ticks_[i].label = labels[i][form];
}

void Axis::choose_log(bool fixed, int wanted) {
  const auto exponent_of = [](double value) {
    return static_cast<int>(std::floor(std::log10(value) + 1e-9));
  };
  if (!fixed) {
    if (high_ <= low_ * (1 + 1e-9)) low_ /= 2, high_ *= 2;
    // Rounded outwards to decades, or where that would waste room to the next of 1, 2, 5.
    const bool decades = std::log10(high_ / low_) > 2.5;
    const double down = power(exponent_of(low_)), up = power(exponent_of(high_));
    const double low_lead = low_ / down, high_lead = high_ / up;
    low_ = down * (decades || low_lead < 1.9999 ? 1 : low_lead < 4.9999 ? 2 : 5);
    high_ = up * (high_lead <= 1.0001 ? 1 : decades || high_lead > 5.0001 ? 10 : high_lead > 2.0001 ? 5 : 2);
  }
  const int first = exponent_of(low_), last = exponent_of(high_);
  const double decades = std::log10(high_ / low_);
  const int stride = std::max(1, static_cast<int>(std::ceil(decades / (1.5 * wanted))));
  const bool leads = decades < 2.01, wide = low_ < 0.99e-3 || high_ > 1.01e4;
  for (int e = first; e <= last; ++e)
    for (int lead = 1; lead <= 9; ++lead) {
      const double value = lead * power(e);
      if (value < low_ * (1 - 1e-9) || value > high_ * (1 + 1e-9) || (lead > 1 && decades > 12)) continue;
      const bool named = (lead == 1 && e % stride == 0) || (leads && (lead == 2 || lead == 5));
      ticks_.push_back({value, !named ? ""
                               : wide ? scientific(value, 0)
                                      : fmt::format("{:.{}f}", value, std::max(-e, 0))});
    }
}

bool Axis::can_show(double value) const {
  return std::isfinite(value) && (!logarithmic_ || value > 0);
}

double Axis::place(double value) const {
  return logarithmic_ ? std::log(value / low_) / std::log(high_ / low_) : (value - low_) / (high_ - low_);
}

} // namespace pliant
