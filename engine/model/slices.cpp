// Bonds as devices store them, and the stiffness that they add up to.
#include "engine/core/error.h"
#include "engine/model/offset.h"

#include <fmt/core.h>

#include <algorithm>

namespace pliant {

namespace {

/// c_ij, N/m: the stiffness of particle i's own half of the bond b = (i, j).
double own_stiffness(const Model& model, std::size_t i, std::size_t bond, double squared) {
  return model.constants[model.material[i]].modulus * model.volume[i] * model.bonds.weight[bond] / squared;
}

/// G_ij.
double strength_of(const Bonds& bonds, std::size_t bond) {
  return bonds.strength.empty() ? 1 : bonds.strength[bond];
}

/// m2, of a bond vector.
double bond_squared(const GridVector& vector, double spacing) {
  const double unit = spacing / reference_grid;
  return static_cast<double>(squared_length(vector)) * (unit * unit);
}

} // namespace

SlicedBonds slice_bonds(const Model& model) {
  const Bonds& bonds = model.bonds;
  const std::vector<GridVector> grid = to_grid(model.reference, model.spacing);
  SlicedBonds sliced;
  sliced.slice_begin.push_back(0);
  std::size_t total = 0;
  for (const LawRange& law : model.laws) {
    if (sliced.slice_begin.size() - 1 != law.first_slice)
      throw Error(ExitCode::internal, fmt::format("the law range at particle {} begins at slice {}, not {}",
                                                  law.first, sliced.slice_begin.size() - 1, law.first_slice));
    for (std::uint32_t first = 0; first < law.count; first += slice_width) {
      std::uint32_t longest = 0;
      for (std::uint32_t lane = first; lane < std::min(first + slice_width, law.count); ++lane)
        longest = std::max(longest, bonds.begin[law.first + lane + 1] - bonds.begin[law.first + lane]);
      total += std::size_t{longest} * slice_width;
      if (total > UINT32_MAX)
        throw Error(ExitCode::too_large,
                    fmt::format("{} particles have more bonds than 32 bits can count; use a "
                                "larger spacing or a smaller horizon",
                                model.count()));
      sliced.slice_begin.push_back(static_cast<std::uint32_t>(total));
    }
  }
  sliced.neighbour.resize(total);
  sliced.offset.resize(total);
  sliced.weight_out.resize(total);
  sliced.weight_in.resize(total);
  if (!bonds.strength.empty()) sliced.strength_out = sliced.strength_in = std::vector<double>(total, 1.0);
  for (const LawRange& law : model.laws) {
    const std::uint32_t slices = (law.count + slice_width - 1) / slice_width;
#pragma omp parallel for schedule(static)
    for (std::uint32_t s = 0; s < slices; ++s) {
      const std::uint32_t begin = sliced.slice_begin[law.first_slice + s];
      const std::uint32_t rows = (sliced.slice_begin[law.first_slice + s + 1] - begin) / slice_width;
      for (std::uint32_t lane = 0; lane < slice_width; ++lane) {
        // Lanes beyond the last particle repeat it, so that every gather stays inside the buffers.
        const std::uint32_t wanted = law.first + s * slice_width + lane;
        const std::uint32_t i = std::min(wanted, law.first + law.count - 1);
        const std::uint32_t used = i == wanted ? bonds.begin[i + 1] - bonds.begin[i] : 0;
        for (std::uint32_t k = 0; k < rows; ++k) {
          const std::size_t at = begin + std::size_t{k} * slice_width + lane;
          if (k >= used) {
            sliced.neighbour[at] = i;
            continue;
          }
          const std::uint32_t bond = bonds.begin[i] + k, j = bonds.neighbour[bond];
          const GridVector vector = grid[j] - grid[i];
          const double squared = bond_squared(vector, model.spacing);
          sliced.neighbour[at] = j;
          sliced.offset[at] = pack_offset(vector);
          sliced.weight_out[at] = own_stiffness(model, i, bond, squared);
          sliced.weight_in[at] = own_stiffness(model, j, bonds.reverse[bond], squared);
          if (bonds.strength.empty()) continue;
          sliced.strength_out[at] = bonds.strength[bond];
          sliced.strength_in[at] = bonds.strength[bonds.reverse[bond]];
        }
      }
    }
  }
  return sliced;
}

double bond_bound(const Model& model, std::size_t i, std::size_t bond) {
  return model.constants[model.material[i]].bound + (strength_of(model.bonds, bond) - 1);
}

std::vector<double> diagonal_stiffness(const Model& model) {
  const Bonds& bonds = model.bonds;
  const std::vector<GridVector> grid = to_grid(model.reference, model.spacing);
  std::vector<double> stiffness(model.count(), 0);
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < model.count(); ++i)
    for (std::uint32_t bond = bonds.begin[i]; bond < bonds.begin[i + 1]; ++bond) {
      const std::uint32_t j = bonds.neighbour[bond];
      const double squared = bond_squared(grid[j] - grid[i], model.spacing);
      stiffness[i] +=
          bond_bound(model, i, bond) * own_stiffness(model, i, bond, squared) +
          bond_bound(model, j, bonds.reverse[bond]) * own_stiffness(model, j, bonds.reverse[bond], squared);
    }
  return stiffness;
}

} // namespace pliant
