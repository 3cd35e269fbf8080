// Bodies with too few particles, and bodies inside each other.
#include "engine/model/checks.h"

#include "engine/model/cells.h"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <map>

namespace pliant {

namespace {

constexpr std::size_t fewest_particles = 8;
/// Three directions, or two, and one to tell the sides apart.
constexpr std::uint32_t fewest_of_solid = 4, fewest_of_sheet = 3;
constexpr double sparse_share = 0.1;
constexpr double closest = 0.5; ///< spacings between particles of different bodies

using Box = Eigen::AlignedBox3d;

/// Where the particles of two bodies are too close to each other.
struct Crossing {
  Box box;                           ///< around the particles of both
  std::size_t first = 0, second = 0; ///< particles of either body
  double depth(double spacing) const { return box.sizes().minCoeff() + spacing; }
};
using Crossings = std::map<std::pair<std::uint32_t, std::uint32_t>, Crossing>;

/// Particles inside the box of another body: the only ones worth looking at.
std::vector<std::uint32_t> candidates(const Model& model, double reach) {
  std::vector<Box> boxes(model.bodies.size());
  for (std::size_t i = 0; i < model.count(); ++i) boxes[model.body[i]].extend(model.position[i]);
  const Vector3 margin = Vector3::Constant(reach);
  std::vector<std::vector<std::uint32_t>> others(boxes.size()); // bodies whose boxes meet
  for (std::uint32_t a = 0; a < boxes.size(); ++a)
    for (std::uint32_t b = 0; b < boxes.size(); ++b)
      if (a != b && !boxes[a].isEmpty() && !boxes[b].isEmpty() &&
          Box(boxes[b].min() - margin, boxes[b].max() + margin).intersects(boxes[a]))
        others[a].push_back(b);
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < model.count(); ++i)
    if (std::any_of(others[model.body[i]].begin(), others[model.body[i]].end(), [&](std::uint32_t b) {
          return Box(boxes[b].min() - margin, boxes[b].max() + margin).contains(model.position[i]);
        }))
      found.push_back(i);
  return found;
}

Crossings find_crossings(const Model& model, double reach) {
  const std::vector<std::uint32_t> particles = candidates(model, reach);
  std::vector<Vector3> points;
  points.reserve(particles.size());
  for (const std::uint32_t i : particles) points.push_back(model.position[i]);
  const CellGrid grid(points, reach);
  const auto body = [&](std::uint32_t sorted) { return model.body[particles[grid.order[sorted]]]; };
  // Runs of one body are skipped at once: a body that starts as a point has them all in one cell.
  const auto count = static_cast<std::uint32_t>(points.size());
  std::vector<std::uint32_t> other(count);
  for (std::uint32_t s = count; s-- > 0;)
    other[s] = s + 1 < count && body(s) == body(s + 1) ? other[s + 1] : s + 1;

  Crossings crossings;
  CellWalk walk(grid, 0);
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    const auto& runs = walk.at(cell);
    for (std::uint32_t s = grid.first[cell]; s < grid.first[cell + 1]; ++s) {
      const auto reaches = [&](const CellRun& run) {
        for (std::uint32_t t = run.first; t < run.last;) {
          if (body(t) == body(s)) {
            t = other[t];
            continue;
          }
          if ((grid.point[t] - grid.point[s]).squaredNorm() < reach * reach) {
            const bool lower = body(s) < body(t);
            Crossing& crossing = crossings[lower ? std::pair(body(s), body(t)) : std::pair(body(t), body(s))];
            ++(lower ? crossing.first : crossing.second);
            crossing.box.extend(grid.point[s]);
            return true;
          }
          ++t;
        }
        return false;
      };
      std::any_of(runs.begin(), runs.end(), reaches);
    }
  }
  return crossings;
}

} // namespace

std::optional<std::string> sparseness(const Bonds& bonds, bool flat) {
  const std::uint32_t fewest_neighbours = flat ? fewest_of_sheet : fewest_of_solid;
  const std::size_t count = bonds.begin.size() - 1;
  if (count < fewest_particles)
    return fmt::format("has {} particle{}, fewer than {}", count, count == 1 ? "" : "s", fewest_particles);
  std::size_t few = 0;
  for (std::size_t i = 0; i < count; ++i) few += bonds.begin[i + 1] - bonds.begin[i] < fewest_neighbours;
  if (static_cast<double>(few) <= sparse_share * static_cast<double>(count)) return std::nullopt;
  return fmt::format("has {} of {} particles with fewer than {} neighbours", few, count, fewest_neighbours);
}

std::optional<Overlap> overlap(const Model& model) {
  if (model.bodies.size() < 2) return std::nullopt;
  const Crossings crossings = find_crossings(model, closest * model.spacing);
  if (crossings.empty()) return std::nullopt;
  const auto deepest =
      std::max_element(crossings.begin(), crossings.end(), [&](const auto& a, const auto& b) {
        return a.second.depth(model.spacing) < b.second.depth(model.spacing);
      });
  const auto& [pair, crossing] = *deepest;
  std::string text =
      fmt::format("bodies '{}' and '{}' overlap by about {:.3g} m: {} particles of the first and {} of "
                  "the second lie within half a spacing ({:.3g} m) of the other body",
                  model.bodies[pair.first].name, model.bodies[pair.second].name,
                  crossing.depth(model.spacing), crossing.first, crossing.second, closest * model.spacing);
  if (crossings.size() > 1) text += fmt::format("; {} more pairs of bodies overlap", crossings.size() - 1);
  return Overlap{pair.second, text};
}

} // namespace pliant
