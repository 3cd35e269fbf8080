// Weights of all bonds: each distinct neighbourhood is solved once.
#include "engine/core/error.h"
#include "engine/model/moments.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <unordered_map>

namespace pliant {

std::vector<GridVector> to_grid(const std::vector<Vector3>& reference, double spacing) {
  std::vector<GridVector> grid(reference.size());
  const double scale = reference_grid / spacing;
  for (std::size_t i = 0; i < reference.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const double value = reference[i][axis] * scale;
      if (!(std::abs(value) < 2e9))
        throw Error(
            ExitCode::usage,
            fmt::format("particle {} lies {} m from its body's origin, which a grid of {} m cannot hold; "
                        "use a larger spacing",
                        i, reference[i][axis], spacing / reference_grid));
      grid[i][static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(std::lround(value));
    }
  return grid;
}

namespace {

/// The bond vectors of particle i. Throws Error(usage) where one cannot be packed or has no length.
void row_vectors(const Bonds& bonds, const std::vector<GridVector>& grid, std::size_t i,
                 std::vector<GridVector>& row) {
  row.clear();
  for (std::uint32_t b = bonds.begin[i]; b < bonds.begin[i + 1]; ++b) {
    row.push_back(grid[bonds.neighbour[b]] - grid[i]);
    const GridVector& v = row.back();
    if (v == GridVector{0, 0, 0})
      throw Error(ExitCode::usage,
                  fmt::format("particles {} and {} coincide; remove one of them", i, bonds.neighbour[b]));
    if (std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}) > offset_reach)
      throw Error(
          ExitCode::usage,
          fmt::format("the bond of particles {} and {} is longer than {:.2f} spacings; use a smaller horizon",
                      i, bonds.neighbour[b], double{offset_reach} / reference_grid));
  }
}

std::uint64_t hash_row(const std::vector<GridVector>& row) {
  std::uint64_t hash = row.size();
  for (const GridVector& v : row) {
    hash = (hash ^ pack_offset(v)) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 29;
  }
  return hash;
}

bool same_row(const Bonds& bonds, const std::vector<GridVector>& grid, std::size_t i, std::size_t j) {
  const std::uint32_t size = bonds.begin[i + 1] - bonds.begin[i];
  if (bonds.begin[j + 1] - bonds.begin[j] != size) return false;
  for (std::uint32_t k = 0; k < size; ++k)
    if (grid[bonds.neighbour[bonds.begin[i] + k]] - grid[i] !=
        grid[bonds.neighbour[bonds.begin[j] + k]] - grid[j])
      return false;
  return true;
}

/// Which particles have the same neighbourhood.
struct Signatures {
  std::vector<std::uint32_t> of;    ///< each particle's
  std::vector<std::uint32_t> model; ///< each signature's first particle
};

Signatures find_signatures(const Bonds& bonds, const std::vector<GridVector>& grid) {
  const std::size_t count = grid.size();
  std::vector<std::uint64_t> hash(count);
  std::exception_ptr failure;
#pragma omp parallel
  {
    std::vector<GridVector> row;
#pragma omp for schedule(static)
    for (std::size_t i = 0; i < count; ++i) {
      try {
        row_vectors(bonds, grid, i, row);
        hash[i] = hash_row(row);
      } catch (...) {
#pragma omp critical(pliant_signatures)
        if (!failure) failure = std::current_exception();
      }
    }
  }
  if (failure) std::rethrow_exception(failure);
  Signatures signatures;
  signatures.of.resize(count);
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> known;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<std::uint32_t>& candidates = known[hash[i]];
    const auto found = std::find_if(candidates.begin(), candidates.end(), [&](std::uint32_t s) {
      return same_row(bonds, grid, i, signatures.model[s]);
    });
    if (found != candidates.end()) {
      signatures.of[i] = *found;
      continue;
    }
    signatures.of[i] = static_cast<std::uint32_t>(signatures.model.size());
    candidates.push_back(signatures.of[i]);
    signatures.model.push_back(static_cast<std::uint32_t>(i));
  }
  return signatures;
}

} // namespace

int moment_order(Law law) {
  return law == Law::corotated || law == Law::neo_hookean ? 2 : 4;
}

WeightReport compute_weights(Bonds& bonds, const std::vector<Vector3>& reference, double spacing, Law law,
                             const std::string& weights, const Influence& influence, int dimension) {
  if (weights != "matched" && weights != "normalised")
    throw Error(ExitCode::usage,
                fmt::format("weights are \"matched\" or \"normalised\", not \"{}\"", weights));
  const std::vector<GridVector> grid = to_grid(reference, spacing);
  const Signatures signatures = find_signatures(bonds, grid);
  const int order = moment_order(law);
  std::vector<NeighbourhoodWeights> solved(signatures.model.size());
#pragma omp parallel
  {
    std::vector<GridVector> row;
#pragma omp for schedule(dynamic, 16)
    for (std::size_t s = 0; s < solved.size(); ++s) {
      row_vectors(bonds, grid, signatures.model[s], row);
      solved[s] = neighbourhood_weights(row, influence, order, weights == "matched", dimension);
    }
  }
  bonds.weight.resize(bonds.count());
  WeightReport report;
  report.signatures = solved.size();
  std::size_t over = 0;
#pragma omp parallel for schedule(static) reduction(+ : over)
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const NeighbourhoodWeights& own = solved[signatures.of[i]];
    std::copy(own.weight.begin(), own.weight.end(), bonds.weight.begin() + bonds.begin[i]);
    if (own.residual > 0.05) ++over;
  }
  for (const NeighbourhoodWeights& s : solved)
    report.worst_residual = std::max(report.worst_residual, s.residual);
  if (!grid.empty())
    report.share_over_5_percent = static_cast<double>(over) / static_cast<double>(grid.size());
  return report;
}

} // namespace pliant
