// Snapping, sorting and bonding a body; connected components by union-find.
#include "engine/model/arrange.h"

#include "engine/core/error.h"
#include "engine/model/offset.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pliant {

namespace {

/// Longest horizon, in spacings, whose bond vectors fit into ten signed bits.
constexpr double longest_horizon = double{offset_reach} / reference_grid;

/// Labels particles by connected component, in the order in which the components first appear.
std::uint32_t label_components(const Bonds& bonds, std::vector<std::uint32_t>& label) {
  const auto count = static_cast<std::uint32_t>(bonds.begin.size() - 1);
  std::vector<std::uint32_t> parent(count);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::uint32_t i = 0; i < count; ++i)
    for (std::uint32_t b = bonds.begin[i]; b < bonds.begin[i + 1] && bonds.neighbour[b] < i; ++b) {
      const std::uint32_t p = root(i), q = root(bonds.neighbour[b]);
      parent[std::max(p, q)] = std::min(p, q);
    }
  // The root is the component's first particle, so it has its label before the others ask for it.
  std::uint32_t components = 0;
  label.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t r = root(i);
    label[i] = r == i ? components++ : label[r];
  }
  return components;
}

std::vector<Vector3> in_order(const std::vector<GridVector>& grid, const std::vector<std::uint32_t>& order,
                              double spacing) {
  std::vector<Vector3> reference(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) reference[i] = from_grid(grid[order[i]], spacing);
  return reference;
}

/// The bonds that are not severed; rows stay sorted and symmetric.
Bonds without(Bonds bonds, const std::vector<Vector3>& reference, const Severed& severed) {
  if (!severed) return bonds;
  const std::size_t count = bonds.begin.size() - 1;
  constexpr std::uint32_t gone = UINT32_MAX;
  std::vector<std::uint32_t> place(bonds.count(), gone);
  Bonds kept;
  kept.begin.push_back(0);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::uint32_t b = bonds.begin[i]; b < bonds.begin[i + 1]; ++b) {
      // Asked from the lower end, so that both directions get one answer.
      const std::uint32_t j = bonds.neighbour[b];
      const bool cut = j < i ? place[bonds.reverse[b]] == gone : severed(reference[i], reference[j]);
      if (cut) continue;
      place[b] = static_cast<std::uint32_t>(kept.neighbour.size());
      kept.neighbour.push_back(j);
      kept.reverse.push_back(bonds.reverse[b]);
    }
    kept.begin.push_back(static_cast<std::uint32_t>(kept.neighbour.size()));
  }
  for (std::uint32_t& reverse : kept.reverse) reverse = place[reverse];
  return kept;
}

/// By z, then y, then x.
std::vector<std::uint32_t> lexicographic_order(const std::vector<GridVector>& grid) {
  std::vector<std::uint32_t> order(grid.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto lexicographic = [&grid](std::uint32_t a, std::uint32_t b) {
    const GridVector &p = grid[a], &q = grid[b];
    if (p[2] != q[2]) return p[2] < q[2];
    if (p[1] != q[1]) return p[1] < q[1];
    return p[0] != q[0] ? p[0] < q[0] : a < b;
  };
  if (!std::is_sorted(order.begin(), order.end(), lexicographic))
    std::sort(order.begin(), order.end(), lexicographic);
  return order;
}

template <class T> void extend(std::vector<T>& whole, std::vector<T>&& part) {
  if (whole.empty())
    whole = std::move(part);
  else
    whole.insert(whole.end(), part.begin(), part.end());
}

} // namespace

Arrangement arrange(const std::vector<Vector3>& points, double spacing, double horizon,
                    const Severed& severed) {
  if (!(spacing > 0) || !std::isfinite(spacing))
    throw Error(ExitCode::usage, fmt::format("the spacing must be a positive length, not {} m", spacing));
  if (!(horizon <= longest_horizon * spacing))
    throw Error(ExitCode::usage,
                fmt::format("the horizon of {:.3g} spacings is longer than the {:.2f} that a bond "
                            "can span; use a smaller one (1.87 is usual)",
                            horizon / spacing, longest_horizon));
  const std::vector<GridVector> grid = to_grid(points, spacing);
  Arrangement body;
  body.original = lexicographic_order(grid);
  for (std::size_t i = 1; i < body.original.size(); ++i) {
    const std::uint32_t a = body.original[i - 1], b = body.original[i];
    if (grid[a] == grid[b])
      throw Error(
          ExitCode::usage,
          fmt::format("particles {} and {} coincide at ({:.6g}, {:.6g}, {:.6g}) m; remove one of them", a, b,
                      points[a].x(), points[a].y(), points[a].z()));
  }
  body.reference = in_order(grid, body.original, spacing);
  body.bonds = without(find_bonds(body.reference, horizon), body.reference, severed);
  body.components = label_components(body.bonds, body.component);
  if (!std::is_sorted(body.component.begin(), body.component.end())) {
    std::vector<std::uint32_t> place(points.size());
    std::iota(place.begin(), place.end(), 0u);
    std::stable_sort(place.begin(), place.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return body.component[a] < body.component[b]; });
    std::vector<std::uint32_t> original(points.size());
    for (std::size_t i = 0; i < place.size(); ++i) original[i] = body.original[place[i]];
    body.original = std::move(original);
    body.reference = in_order(grid, body.original, spacing);
    body.bonds = without(find_bonds(body.reference, horizon), body.reference, severed);
    body.components = label_components(body.bonds, body.component);
  }
  return body;
}

Arrangement arrange_unbonded(const std::vector<Vector3>& points, double spacing) {
  const std::vector<GridVector> grid = to_grid(points, spacing);
  Arrangement body;
  body.original = lexicographic_order(grid);
  body.reference = in_order(grid, body.original, spacing);
  body.component.assign(points.size(), 0);
  body.components = points.empty() ? 0 : 1;
  body.bonds.begin.assign(points.size() + 1, 0);
  return body;
}

void append(Model& model, std::uint32_t body, Law law, BodyParticles&& particles) {
  Arrangement& part = particles.arrangement;
  const auto first = static_cast<std::uint32_t>(model.count());
  const auto count = static_cast<std::uint32_t>(part.reference.size());
  const std::size_t first_bond = model.bonds.count();
  if (std::size_t{first} + count >= UINT32_MAX || first_bond + part.bonds.count() > UINT32_MAX)
    throw Error(ExitCode::too_large,
                "the scene has more particles or bonds than 32 bits can count; use a larger "
                "spacing or a smaller horizon");
  model.bodies[body].first = first;
  model.bodies[body].count = count;
  if (count > 0 && (model.laws.empty() || model.laws.back().law != law)) {
    const std::uint32_t slices =
        model.laws.empty()
            ? 0
            : model.laws.back().first_slice + (model.laws.back().count + slice_width - 1) / slice_width;
    model.laws.push_back({law, first, 0, slices});
  }
  if (count > 0) model.laws.back().count += count;
  for (std::uint32_t& place : part.original) place += particles.first_id;
  for (std::uint32_t& label : part.component) label += model.components;
  model.components += part.components;
  for (std::uint32_t& b : part.bonds.begin) b += static_cast<std::uint32_t>(first_bond);
  for (std::uint32_t& j : part.bonds.neighbour) j += first;
  for (std::uint32_t& b : part.bonds.reverse) b += static_cast<std::uint32_t>(first_bond);
  if (!model.bonds.begin.empty()) model.bonds.begin.pop_back();
  extend(model.bonds.begin, std::move(part.bonds.begin));
  extend(model.bonds.neighbour, std::move(part.bonds.neighbour));
  extend(model.bonds.reverse, std::move(part.bonds.reverse));
  extend(model.bonds.weight, std::move(part.bonds.weight));
  extend(model.reference, std::move(part.reference));
  extend(model.position, std::move(particles.position));
  extend(model.velocity, std::move(particles.velocity));
  extend(model.volume, std::move(particles.volume));
  extend(model.mass, std::move(particles.mass));
  extend(model.material, std::move(particles.material));
  extend(model.id, std::move(part.original));
  extend(model.component, std::move(part.component));
  model.body.resize(model.position.size(), body);
}

void merge(WeightReport& whole, const WeightReport& part, std::size_t before, std::size_t added) {
  whole.worst_residual = std::max(whole.worst_residual, part.worst_residual);
  whole.signatures += part.signatures;
  if (before + added == 0) return;
  whole.share_over_5_percent = (whole.share_over_5_percent * static_cast<double>(before) +
                                part.share_over_5_percent * static_cast<double>(added)) /
                               static_cast<double>(before + added);
}

} // namespace pliant
