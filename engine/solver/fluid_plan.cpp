// Buffers and kernels of fluids.
#include "engine/solver/fluid.h"
#include "engine/solver/state.h"
#include "shaders/common/contact.glsl"
#include "shaders/common/fluid.glsl"

#include "kernels/fluid_cell.h"
#include "kernels/fluid_finish.h"
#include "kernels/fluid_gather.h"
#include "kernels/fluid_lambda.h"
#include "kernels/fluid_project.h"
#include "kernels/fluid_shift.h"
#include "kernels/fluid_sort.h"
#include "kernels/fluid_speed.h"
#include "kernels/fluid_sum.h"
#include "kernels/fluid_warm.h"
#include "kernels/grid_clear.h"
#include "kernels/grid_place.h"
#include "kernels/grid_scan.h"
#include "kernels/grid_sum.h"
#include "kernels/grid_totals.h"
#include "kernels/near_find.h"

namespace pliant {

FluidPlan plan_fluid(const Scene& scene, const Model& model, bool statistics) {
  FluidPlan plan;
  plan.model = fluid_model(scene, model);
  const std::size_t n = plan.model.count, places = plan.model.places, sorted = plan.model.sorted();
  if (n == 0) return plan;
  plan.walls = !scene.boundaries.empty();
  for (const FluidConstants& c : plan.model.constants) plan.pulls = plan.pulls || c.strength > 0;
  std::string component;
  const auto buffer = [&](const char* name, Type type, std::size_t count) {
    plan.buffers.push_back({name, type, count, component});
  };
  const auto kernel = [&](const auto& args) { plan.kernels.push_back(kernel_variant(args, component)); };

  component = "neighbours";
  plan.cells = plan.model.lattice.count() + 1; // and that of removed particles
  plan.chunks = (plan.cells + SCAN_CHUNK - 1) / SCAN_CHUNK;
  buffer("fluid_kind", Type::uint, n);
  buffer("near_cell_count", Type::uint, plan.cells);
  buffer("near_chunk_begin", Type::uint, plan.chunks);
  buffer("near_cell_begin", Type::uint, std::size_t{plan.cells} + 1);
  buffer("near_cell_of", Type::uint, sorted);
  buffer("near_placed", Type::uint, sorted);
  buffer("near_left_out", Type::uint, 2);
  buffer("near_count", Type::uint, places / slice_width);
  buffer("near", Type::uint, places * plan.model.rows);
  buffer("fluid_particle", Type::uint, sorted);
  buffer("fluid_place", Type::real4, places);
  buffer("fluid_velocity", Type::real4, places);
  buffer("fluid_start", Type::real4, places);
  kernel(kernels::grid_clear::Args{});
  kernel(kernels::fluid_cell::Args{});
  kernel(kernels::grid_sum::Args{});
  kernel(kernels::grid_totals::Args{});
  kernel(kernels::grid_scan::Args{});
  kernel(kernels::grid_place::Args{});
  kernel(kernels::fluid_sort::Args{});
  kernel(kernels::fluid_gather::Args{});
  kernel(kernels::near_find::Args{});

  component = "density";
  buffer("fluid_material", Type::real4, std::size_t{FLUIDS} * FLUID_ROWS);
  buffer("fluid_lambda", Type::real4, places);
  buffer("fluid_pull", Type::real4, places);
  buffer("fluid_moved", Type::real4, places);
  buffer("fluid_total", Type::real, places);
  kernel(kernels::fluid_warm::Args{});
  kernel(kernels::fluid_lambda::Args{.warm = 1, .walls = plan.walls});
  kernel(kernels::fluid_lambda::Args{.walls = plan.walls, .pulls = plan.pulls});
  kernel(kernels::fluid_shift::Args{});
  kernel(kernels::fluid_speed::Args{});
  kernel(kernels::fluid_finish::Args{.bounded = scene.domain.given});
  if (statistics) {
    buffer("fluid_measure", Type::real4, places);
    buffer("fluid_row", Type::real, std::size_t{8} * statistics_rows);
    kernel(kernels::fluid_lambda::Args{.measured = 1, .walls = plan.walls});
    kernel(kernels::fluid_sum::Args{});
  }

  component = "boundaries";
  if (plan.walls) {
    const Obstacles obstacles(scene, plan.model.reach, model.spacing, true);
    plan.meshes = obstacles.meshes();
    buffer("obstacle", Type::real4, std::size_t{OBSTACLES} * OBSTACLE_ROWS);
    if (plan.meshes) {
      buffer("obstacle_grid", Type::uint4, OBSTACLES);
      buffer("grid_distance", Type::real, obstacles.grid_nodes());
    }
    buffer("fluid_wall", Type::real4, places);
    kernel(kernels::fluid_project::Args{.meshes = plan.meshes});
  }
  plan.forces = plan_forces(scene, model, plan.model);
  if (plan.walls && plan.forces.spread)
    kernel(kernels::fluid_project::Args{.meshes = plan.meshes, .spread = 1});
  plan.flow = plan_flow(scene, model);
  list_flow(plan.flow, plan.buffers, plan.kernels);
  list_forces(plan.forces, plan.model, statistics, plan.buffers, plan.kernels);
  plan.bonds = fluid_bonds(scene, model, plan.model);
  list_bonds(plan, statistics);
  return plan;
}

} // namespace pliant
