// Constants and cells of fluids.
#include "engine/model/fluid.h"

#include "engine/core/error.h"
#include "shaders/common/fluid.glsl"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

// Of a full neighbourhood's sum_k |grad_k C|^2 / m_k. More makes the constraint soft, less lets a particle
// with few neighbours jump.
constexpr double softness_share = 0.01;
// reach |grad rho| / rho_0 of a particle at a surface; on a half lattice it is about 1.6, inside a shaken one
// below this.
constexpr double surface_share = 0.2;
// Of the reach, that lists of matter with bonds see further.
constexpr double bonded_margin = 0.1;
// Cells are a little wider than the reach, so that rounding cannot part two particles by two cells.
constexpr double cell_slack = 1.001;
constexpr std::uint32_t fewest_cells = 4096;
// Particles may crowd to twice the density of the lattice before a list is full.
constexpr double crowding = 2;

FluidConstants constants_of(const Material& material, const Smoothing& smoothing, double spacing,
                            double depth) {
  const int d = smoothing.dimension;
  const double mass = material.density * std::pow(spacing, d) * depth;
  FluidConstants c;
  c.rest = mass * smoothing.lattice_density(spacing);
  c.viscosity = material.viscosity;
  c.redistribution = material.redistribution;
  c.surface_tension = material.surface_tension;
  const double squares = smoothing.lattice_sum(spacing, [&](double r) {
    const double slope = r > 0 ? smoothing.spline_derivative(r) : 0;
    return slope * slope;
  });
  c.softness = softness_share * mass * squares / (c.rest * c.rest);
  c.edge = surface_share * c.rest / smoothing.support;
  c.strength = material.tensile_strength / (c.rest * c.rest);
  return c;
}

double wall_share(const Smoothing& smoothing, double spacing) {
  double own = 0; // of the layer that a particle lies in
  const int reach = static_cast<int>(smoothing.support / spacing);
  for (int y = smoothing.dimension == 2 ? 0 : -reach; y <= (smoothing.dimension == 2 ? 0 : reach); ++y)
    for (int x = -reach; x <= reach; ++x) own += smoothing.spline_value(spacing * std::hypot(x, y));
  const double beyond = (1 - own / smoothing.lattice_density(spacing)) / 2;
  const double a = 1 - spacing / (2 * smoothing.support),
               b = 2 * a - 1; // as shaders/fluid_project.comp has it
  return beyond / (std::pow(a, 5) * (1.6 - 16. / 15 * a) - std::pow(b, 5) * (0.1 - b / 15));
}

/// Cells in the directions in which nothing repeats: about what the fluid fills now, twice, so that it has
/// room to spread before far particles share cells.
FluidLattice lattice_of(const Scene& scene, const Model& model, double reach, std::uint32_t particles) {
  FluidLattice lattice;
  Vector3 low = model.position.front(), high = low;
  for (const Vector3& p : model.position) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const DomainSettings& domain = scene.domain;
  // In the middle of the fluid: a place so many spacings away loses as many times a spacing's rounding, and
  // so does every distance between neighbours. Snapped, so that moving a scene by a round distance moves no
  // bit of it.
  const double grain = std::exp2(std::ceil(std::log2(model.spacing)));
  lattice.base = ((low + high) / (2 * grain)).array().round() * grain;
  const double cell = cell_slack * reach;
  std::array<double, 3> wanted{};
  // Of what emitters make nobody knows where it goes: a cube of cells for all of it.
  const double least = scene.emitters.empty() ? 0 : std::ceil(std::cbrt(std::max(particles, fewest_cells)));
  for (int a = 0; a < 3; ++a) {
    const bool repeats = domain.given && domain.periodic[static_cast<std::size_t>(a)];
    lattice.edge[a] = cell;
    if (repeats) {
      lattice.base[a] = domain.low[a]; // images are those of places from 0 to the period
      lattice.period[a] = domain.high[a] - domain.low[a];
      const double cells = std::floor(lattice.period[a] / cell);
      if (cells < 3)
        throw Error(
            ExitCode::usage,
            fmt::format("{}: the domain repeats after {:.4g} m along {}, less than three times the "
                        "reach of the fluid ({:.4g} m): make it {:.4g} m or more, or the spacing smaller",
                        scene.file.string(), lattice.period[a], "xyz"[a], reach, 3 * cell));
      lattice.cells[static_cast<std::size_t>(a)] = static_cast<std::uint32_t>(cells);
      lattice.edge[a] = lattice.period[a] / cells;
    } else {
      wanted[static_cast<std::size_t>(a)] = std::max(2 * (std::ceil((high[a] - low[a]) / cell) + 1), least);
      if (domain.given)
        wanted[static_cast<std::size_t>(a)] = std::min(
            wanted[static_cast<std::size_t>(a)], std::ceil((domain.high[a] - domain.low[a]) / cell) + 1);
    }
  }
  if (model.dimension == 2) wanted[2] = 1;
  const double most = std::max(particles, fewest_cells);
  const auto total = [&] {
    double product = 1;
    for (std::size_t a = 0; a < 3; ++a) product *= wanted[a] > 0 ? wanted[a] : lattice.cells[a];
    return product;
  };
  while (total() > most) { // the longest direction first
    const auto longest = std::max_element(wanted.begin(), wanted.end());
    if (*longest <= 4) break;
    *longest = std::floor(*longest * 0.8);
  }
  for (std::size_t a = 0; a < 3; ++a)
    if (wanted[a] > 0) lattice.cells[a] = static_cast<std::uint32_t>(wanted[a]);
  return lattice;
}

} // namespace

FluidModel fluid_model(const Scene& scene, const Model& model) {
  FluidModel fluid;
  for (const LawRange& range : model.laws)
    if (range.law == Law::fluid) fluid.first = range.first, fluid.count = range.count;
  if (fluid.count == 0) return fluid;
  fluid.ghosts = sample_ghosts(scene, model);
  fluid.spacing = model.spacing;
  fluid.places = (fluid.sorted() + slice_width - 1) / slice_width * slice_width;
  fluid.reach = scene.fluid.horizon * model.spacing;
  const auto own = model.material.begin() + fluid.first;
  const bool bonded = std::any_of(own, own + fluid.count,
                                  [&](std::uint32_t material) { return scene.materials[material].bonded(); });
  fluid.list_reach = (bonded ? 1 + bonded_margin : 1) * fluid.reach;
  fluid.smoothing = {fluid.reach, static_cast<int>(model.dimension)};
  fluid.wall_share = wall_share(fluid.smoothing, model.spacing);
  std::vector<std::uint32_t> index(scene.materials.size(), 0);
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    if (!scene.materials[m].fluid()) continue;
    index[m] = static_cast<std::uint32_t>(fluid.constants.size());
    fluid.constants.push_back(constants_of(scene.materials[m], fluid.smoothing, model.spacing, 1));
  }
  if (fluid.constants.size() > FLUIDS)
    throw Error(ExitCode::usage, fmt::format("{}: the scene has {} fluid materials; at most {} are possible",
                                             scene.file.string(), fluid.constants.size(), FLUIDS));
  for (std::uint32_t i = fluid.first; i < fluid.first + fluid.count; ++i)
    fluid.kind.push_back(model.body[i] | index[model.material[i]] << FLUID_KIND_SHIFT);
  fluid.lattice = lattice_of(scene, model, fluid.list_reach, fluid.count);
  const Smoothing listed{fluid.list_reach, fluid.smoothing.dimension};
  const double around = listed.lattice_sum(model.spacing, [](double) { return 1; }) - 1;
  const auto room = static_cast<std::uint32_t>(std::ceil(crowding * around / 8) * 8);
  fluid.rows = scene.fluid.neighbours.value_or(model.dimension == 2 ? room + 8 : room);
  return fluid;
}

} // namespace pliant
