// Nested dissection of a model's bonds.
#include "engine/model/dissection.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace pliant {

namespace {

/// Fewer particles than this are eliminated together: a dense block of them costs less than its cuts would.
constexpr std::size_t smallest_cut = 48;

using Particles = std::vector<std::uint32_t>;

class Cutter {
public:
  Cutter(const Model& model, Dissection& result) : model_(model), result_(result), mark_(model.count(), 0) {}

  /// The front at the root of these particles' tree; -1 where there are none.
  std::int32_t cut(Particles particles) {
    if (particles.empty()) return -1;
    std::array<std::int32_t, 2> child{-1, -1};
    if (particles.size() > smallest_cut) {
      Particles best_side[2], best_separator;
      std::size_t least = std::numeric_limits<std::size_t>::max();
      for (int axis = 0; axis < 3; ++axis) {
        Particles side[2], separator;
        if (!halve(particles, axis, side, separator) || separator.size() >= least) continue;
        least = separator.size();
        std::swap(best_side, side);
        std::swap(best_separator, separator);
      }
      if (least < particles.size()) {
        particles = {};
        child = {cut(std::move(best_side[0])), cut(std::move(best_side[1]))};
        return front(best_separator, child);
      }
    }
    return front(particles, child);
  }

private:
  /// Cuts at the median: the separator is the thinner of the two layers that touch across it. False where
  /// nothing would be left on one side.
  bool halve(Particles particles, int axis, Particles* side, Particles& separator) {
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
      const double xa = model_.reference[a][axis], xb = model_.reference[b][axis];
      return xa < xb || (xa == xb && a < b);
    };
    const auto middle = particles.begin() + static_cast<std::ptrdiff_t>(particles.size() / 2);
    std::nth_element(particles.begin(), middle, particles.end(), before);
    const std::uint32_t left = ++stamp_, right = ++stamp_;
    for (auto p = particles.begin(); p != particles.end(); ++p) mark_[*p] = p < middle ? left : right;
    std::array<Particles, 2> touching;
    const auto across = [&](std::uint32_t i) {
      const std::uint32_t other = mark_[i] == left ? right : left;
      const auto begin = model_.bonds.neighbour.begin();
      return std::any_of(begin + model_.bonds.begin[i], begin + model_.bonds.begin[i + 1],
                         [&](std::uint32_t j) { return mark_[j] == other; });
    };
    for (const std::uint32_t i : particles)
      if (across(i)) touching[mark_[i] == left ? 0 : 1].push_back(i);
    separator = std::move(touching[touching[0].size() <= touching[1].size() ? 0 : 1]);
    const std::uint32_t taken = ++stamp_;
    for (const std::uint32_t i : separator) mark_[i] = taken;
    for (const std::uint32_t i : particles)
      if (mark_[i] != taken) side[mark_[i] == left ? 0 : 1].push_back(i);
    return !side[0].empty() && !side[1].empty();
  }

  std::int32_t front(Particles own, std::array<std::int32_t, 2> child) {
    std::sort(own.begin(), own.end());
    Front f;
    f.first = static_cast<std::uint32_t>(result_.order.size());
    f.columns = static_cast<std::uint32_t>(own.size());
    f.child = child;
    for (const std::int32_t c : child)
      if (c >= 0) f.level = std::max(f.level, result_.fronts[static_cast<std::size_t>(c)].level + 1);
    for (const std::uint32_t i : own) {
      result_.place[i] = static_cast<std::uint32_t>(result_.order.size());
      result_.order.push_back(i);
    }
    result_.levels = std::max(result_.levels, f.level + 1);
    result_.fronts.push_back(f);
    return static_cast<std::int32_t>(result_.fronts.size()) - 1;
  }

  const Model& model_;
  Dissection& result_;
  std::vector<std::uint32_t> mark_; ///< the latest cut's stamps
  std::uint32_t stamp_ = 0;
};

/// Each front's rows: what its particles are bonded to and what its children leave, as far as it comes later.
void find_rows(const Model& model, Dissection& d) {
  Particles rows;
  for (Front& f : d.fronts) {
    const std::uint32_t end = f.first + f.columns;
    rows.clear();
    for (std::uint32_t p = f.first; p < end; ++p) {
      const std::uint32_t i = d.order[p];
      for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
        const std::uint32_t q = d.place[model.bonds.neighbour[b]];
        if (q != Dissection::nowhere && q >= end) rows.push_back(q);
      }
    }
    for (const std::int32_t c : f.child) {
      if (c < 0) continue;
      const Front& child = d.fronts[static_cast<std::size_t>(c)];
      for (std::uint32_t r = child.row_begin; r < child.row_end; ++r)
        if (d.row[r] >= end) rows.push_back(d.row[r]);
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    f.row_begin = static_cast<std::uint32_t>(d.row.size());
    d.row.insert(d.row.end(), rows.begin(), rows.end());
    f.row_end = static_cast<std::uint32_t>(d.row.size());
  }
}

} // namespace

std::uint32_t Dissection::within(const Front& f, std::uint32_t wanted) const {
  if (wanted < f.first + f.columns) return wanted - f.first;
  const auto begin = row.begin() + f.row_begin, end = row.begin() + f.row_end;
  return f.columns + static_cast<std::uint32_t>(std::lower_bound(begin, end, wanted) - begin);
}

double Dissection::entries() const {
  double sum = 0;
  for (const Front& f : fronts) sum += double(f.columns) * (double(f.columns) + f.rows());
  return sum;
}

Dissection dissect(const Model& model) {
  Dissection d;
  d.place.assign(model.count(), Dissection::nowhere);
  std::vector<bool> free(model.count(), true);
  for (const Held& held : model.held)
    if (!model.motions[held.motion].release.value_or(false)) free[held.particle] = false;
  Particles particles;
  for (std::uint32_t i = 0; i < model.count(); ++i)
    if (free[i]) particles.push_back(i);
  d.order.reserve(particles.size());
  Cutter(model, d).cut(std::move(particles));
  find_rows(model, d);
  return d;
}

} // namespace pliant
