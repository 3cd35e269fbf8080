// Runs the kernels of fluids.
#include "engine/solver/fluid.h"

#include "engine/plan/plan.h"
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

#include <algorithm>
#include <utility>

namespace pliant {

namespace {

// Of the multipliers of the last step. Without, a column of 20 particles is 1.1 % too dense in the mean; with
// 0.9 it boils: what one splash needed goes on to push.
constexpr double warm_share = 0.5;
// Neighbours correct the same density at once: with 1 a column at rest explodes.
constexpr double relaxation = 0.5;
// What a sweep is taken to leave of an error at most; what converges without (0) does so with any. Five
// sweeps of honey that is poured leave 1.2 % in the mean instead of 2.1 %. 0.9 leaves 0.8 %, but in a
// collision roundings grow thirty times as much.
constexpr double spectral_radius = 0.8, radius2 = spectral_radius * spectral_radius;
// C beyond which a sweep corrects no more at once, so that what was poured into one place parts in some
// steps.
constexpr double largest_error = 0.25;

bool moves(const Boundary& boundary) {
  const Motion& motion = boundary.motion;
  return motion.rate != 0 || !motion.velocity.isZero(0) || motion.release.value_or(false);
}

} // namespace

Fluid::Fluid(Device& device, const Scene& scene, const Model& model, const Plan& plan, SimulationState& state,
             const Vector3& scene_origin)
    : device_(device), scene_(scene), state_(state), watched_(plan.statistics),
      plan_(plan_fluid(scene, model, plan.statistics)), obstacles_(scene, plan_.model.reach, model.spacing) {
  for (const BufferSpec& spec : plan_.buffers)
    buffers_.emplace(spec.name, device.allocate(spec.name, spec.type, spec.count));
  origin_ = plan_.model.lattice.base;
  base_ = origin_ - scene_origin;
  device_.upload(buffer("fluid_kind"), plan_.model.kind);
  std::vector<Real4<double>> rows(std::size_t{FLUIDS} * FLUID_ROWS);
  for (std::size_t m = 0; m < plan_.model.constants.size(); ++m) {
    const FluidConstants& c = plan_.model.constants[m];
    rows[FLUID_ROWS * m + FLUID_TRAITS] = {c.rest, c.viscosity, c.redistribution, c.surface_tension};
    rows[FLUID_ROWS * m + FLUID_LIMITS] = {c.softness, largest_error, c.edge, c.strength};
  }
  device_.upload(buffer("fluid_material"), rows);
  forces_ = std::make_unique<FluidForces>(device_, scene_, *this, origin_);
  if (plan_.bonds.any) elastic_ = std::make_unique<FluidElastic>(device_, scene_, *this, state_);
  if (plan_.flow.used())
    flow_ = std::make_unique<FluidFlow>(device_, scene_, model, *this, state_, origin_, base_);
  if (!plan_.walls) return;
  still_ = std::none_of(scene.boundaries.begin(), scene.boundaries.end(), moves);
  if (still_) device_.upload(buffer("obstacle"), obstacle_rows(0, 0));
  if (!plan_.meshes) return;
  device_.upload(buffer("obstacle_grid"), obstacles_.grid_table());
  device_.upload(buffer("grid_distance"), obstacles_.take_distances());
}

std::vector<Real4<double>> Fluid::obstacle_rows(double begin, double end) const {
  std::vector<Real4<double>> rows = obstacles_.table(begin, end, origin_);
  for (const Ghost& ghost : plan_.model.ghosts)
    rows[std::size_t{OBSTACLE_ROWS} * ghost.boundary + OBSTACLE_KIND].z = OBSTACLE_GHOSTS;
  return rows;
}

BufferStorage* Fluid::buffer(const std::string& name) const {
  const auto found = buffers_.find(name);
  return found == buffers_.end() ? nullptr : static_cast<BufferStorage*>(found->second);
}

template <class Args> void Fluid::in_lattice(Args& args) const {
  const FluidLattice& lattice = plan_.model.lattice;
  args.per_cell_x = 1 / lattice.edge.x();
  args.per_cell_y = 1 / lattice.edge.y();
  args.per_cell_z = 1 / lattice.edge.z();
  args.cells_x = lattice.cells[0];
  args.cells_y = lattice.cells[1];
  args.cells_z = lattice.cells[2];
}

template <class Args> void Fluid::in_period(Args& args) const {
  const Vector3& period = plan_.model.lattice.period;
  args.period_x = period.x();
  args.period_y = period.y();
  args.period_z = period.z();
}

template <class Args> void Fluid::in_flight(Args& args, double step) const {
  const Vector3& g = scene_.simulation.gravity;
  args.time_step = step;
  args.gravity_x = g.x();
  args.gravity_y = g.y();
  args.gravity_z = g.z();
  args.base_x = base_.x();
  args.base_y = base_.y();
  args.base_z = base_.z();
  args.position = state_.position;
  args.velocity = state_.velocity;
  args.fluid_kind = buffer("fluid_kind");
  args.origin = state_.origin;
}

void Fluid::advance(double time, double end, double step) {
  FluidBirths births;
  if (flow_) births = flow_->make_room(time, end);
  if (plan_.walls && !still_) {
    device_.enter("boundaries");
    device_.upload(buffer("obstacle"), obstacle_rows(time, time + step));
  }
  forces_->move_ghosts(time, time + step);
  if (elastic_) elastic_->keep_lists();
  find(step);
  if (elastic_) elastic_->carry();
  forces_->viscosity(step);
  if (elastic_) elastic_->solve(step);
  density(step);
  if (elastic_) elastic_->settle(watched_);
  spread();
  if (elastic_) elastic_->hold(), elastic_->flow();
  finish(step);
  if (flow_) flow_->end_step(births, end);
}

void Fluid::find(double step) {
  const std::uint32_t n = plan_.model.count, places = plan_.model.places;
  device_.enter("neighbours");
  device_.run(kernels::grid_clear::Args{
      .threads = plan_.cells, .cell_count = buffer("near_cell_count"), .left_out = buffer("near_left_out")});
  kernels::fluid_cell::Args cell{.threads = n};
  in_flight(cell, step);
  in_lattice(cell);
  cell.cell_of = buffer("near_cell_of");
  cell.cell_count = buffer("near_cell_count");
  device_.run(cell);
  forces_->sort_ghosts();
  device_.run(kernels::grid_sum::Args{.threads = plan_.chunks * kernels::grid_sum::group_size,
                                      .cells = plan_.cells,
                                      .cell_count = buffer("near_cell_count"),
                                      .chunk_begin = buffer("near_chunk_begin")});
  device_.run(kernels::grid_totals::Args{.threads = kernels::grid_totals::group_size,
                                         .chunks = plan_.chunks,
                                         .chunk_begin = buffer("near_chunk_begin")});
  device_.run(kernels::grid_scan::Args{.threads = plan_.chunks * kernels::grid_scan::group_size,
                                       .cells = plan_.cells,
                                       .chunk_begin = buffer("near_chunk_begin"),
                                       .cell_count = buffer("near_cell_count"),
                                       .cell_begin = buffer("near_cell_begin")});
  device_.run(kernels::grid_place::Args{.threads = plan_.model.sorted(),
                                        .cell_of = buffer("near_cell_of"),
                                        .cell_next = buffer("near_cell_count"),
                                        .placed = buffer("near_placed")});
  device_.run(kernels::fluid_sort::Args{.threads = plan_.model.sorted(),
                                        .cells = plan_.cells,
                                        .cell_begin = buffer("near_cell_begin"),
                                        .cell_of = buffer("near_cell_of"),
                                        .placed = buffer("near_placed"),
                                        .fluid_particle = buffer("fluid_particle")});
  kernels::fluid_gather::Args gather{.threads = places};
  in_flight(gather, step);
  gather.particle_count = n;
  gather.ghost_count = plan_.model.sorted() - n;
  gather.fluid_particle = buffer("fluid_particle");
  gather.fluid_place = buffer("fluid_place");
  gather.fluid_velocity = buffer("fluid_velocity");
  gather.fluid_start = buffer("fluid_start");
  device_.run(gather);
  forces_->gather_ghosts();
  kernels::near_find::Args near{
      .threads = places, .places = places, .rows = plan_.model.rows, .particle_count = n};
  near.reach = plan_.model.list_reach;
  in_lattice(near);
  in_period(near);
  near.cell_begin = buffer("near_cell_begin");
  near.fluid_place = buffer("fluid_place");
  near.fluid_particle = buffer("fluid_particle");
  near.near_count = buffer("near_count");
  near.near = buffer("near");
  near.left_out = buffer("near_left_out");
  device_.run(near);
}

void Fluid::shift() {
  kernels::fluid_shift::Args args{.threads = plan_.model.places, .rows = plan_.model.rows};
  args.support = plan_.model.smoothing.support;
  args.slope_scale = plan_.model.smoothing.spline_gradient();
  in_period(args);
  args.fluid_lambda = buffer("fluid_lambda");
  args.fluid_pull = buffer("fluid_pull");
  args.near_count = buffer("near_count");
  args.near = buffer("near");
  args.fluid_start = buffer("fluid_start");
  args.fluid_moved = buffer("fluid_moved");
  args.fluid_place = buffer("fluid_place");
  device_.run(args);
}

void Fluid::project(bool spread) {
  if (!plan_.walls) return;
  device_.enter("boundaries");
  device_.run(kernels::fluid_project::Args{.threads = plan_.model.places,
                                           .meshes = plan_.meshes,
                                           .spread = spread,
                                           .obstacles = obstacles_.count(),
                                           .radius = plan_.model.reach / scene_.fluid.horizon / 2,
                                           .support = plan_.model.smoothing.support,
                                           .share = plan_.model.wall_share,
                                           .obstacle = buffer("obstacle"),
                                           .grid = buffer("obstacle_grid"),
                                           .fluid_start = buffer("fluid_start"),
                                           .grid_distance = buffer("grid_distance"),
                                           .fluid_place = buffer("fluid_place"),
                                           .fluid_wall = buffer("fluid_wall"),
                                           .fluid_moved = buffer("fluid_moved")});
  device_.enter("density");
}

namespace {

kernels::fluid_lambda::Args lambda_args(const Fluid& fluid) {
  const FluidModel& model = fluid.plan().model;
  kernels::fluid_lambda::Args args{.threads = model.places, .walls = fluid.plan().walls, .rows = model.rows};
  args.fluid_wall = fluid.buffer("fluid_wall");
  args.support = model.smoothing.support;
  args.value_scale = model.smoothing.spline();
  args.slope_scale = model.smoothing.spline_gradient();
  args.fluid_material = fluid.buffer("fluid_material");
  args.fluid_place = fluid.buffer("fluid_place");
  args.fluid_velocity = fluid.buffer("fluid_velocity");
  args.near_count = fluid.buffer("near_count");
  args.near = fluid.buffer("near");
  args.fluid_total = fluid.buffer("fluid_total");
  args.fluid_lambda = fluid.buffer("fluid_lambda");
  args.fluid_pull = fluid.buffer("fluid_pull");
  args.fluid_measure = fluid.buffer("fluid_measure");
  return args;
}

} // namespace

void Fluid::density(double step) {
  device_.enter("density");
  device_.run(kernels::fluid_warm::Args{.threads = plan_.model.places,
                                        .share = warm_share * step * step,
                                        .time_step = step,
                                        .fluid_start = buffer("fluid_start"),
                                        .fluid_velocity = buffer("fluid_velocity"),
                                        .fluid_total = buffer("fluid_total"),
                                        .fluid_moved = buffer("fluid_moved")});
  project();
  double omega = 1;
  for (unsigned k = 0; k <= scene_.fluid.density_iterations;
       ++k) { // before the first, those of the last step
    kernels::fluid_lambda::Args args = lambda_args(*this);
    in_period(args);
    args.warm = k == 0;
    args.pulls = plan_.pulls && k > 0;
    args.step2 = step * step;
    // Chebyshev's semi-iteration (Wang 2015).
    if (k > 1) omega = k == 2 ? 2 / (2 - radius2) : 4 / (4 - radius2 * omega);
    args.relaxation = omega * relaxation;
    args.momentum = omega - 1;
    device_.run(args);
    shift();
    project();
  }
  device_.run(kernels::fluid_speed::Args{.threads = plan_.model.places,
                                         .time_step = step,
                                         .fluid_moved = buffer("fluid_moved"),
                                         .fluid_place = buffer("fluid_place"),
                                         .fluid_velocity = buffer("fluid_velocity")});
}

void Fluid::spread() {
  if (!plan_.forces.spread) return;
  for (unsigned k = 0; k < scene_.fluid.redistribution_iterations; ++k) {
    forces_->spread();
    swap(buffers_.at("fluid_place"), buffers_.at("fluid_shift"));
    project(true);
  }
}

std::unique_ptr<Readback> Fluid::force_sums(std::uint32_t row) {
  return watched_ ? forces_->sums(row) : nullptr;
}

std::unique_ptr<Readback> Fluid::bond_sums(std::uint32_t row) {
  return watched_ && elastic_ ? elastic_->sums(row) : nullptr;
}

void Fluid::finish(double step) {
  device_.enter("density");
  if (watched_) {
    kernels::fluid_lambda::Args args = lambda_args(*this);
    in_period(args);
    args.measured = 1;
    device_.run(args);
  }
  const FluidLattice& lattice = plan_.model.lattice;
  const Vector3 low = scene_.domain.low - lattice.base, high = scene_.domain.high - lattice.base;
  kernels::fluid_finish::Args args{.threads = plan_.model.sorted(), .bounded = scene_.domain.given};
  args.particle_count = plan_.model.count;
  args.time_step = step;
  args.base_x = base_.x(), args.base_y = base_.y(), args.base_z = base_.z();
  args.low_x = low.x(), args.low_y = low.y(), args.low_z = low.z();
  args.high_x = high.x(), args.high_y = high.y(), args.high_z = high.z();
  in_period(args);
  args.fluid_particle = buffer("fluid_particle");
  args.fluid_place = buffer("fluid_place");
  args.fluid_velocity = buffer("fluid_velocity");
  args.fluid_total = buffer("fluid_total");
  args.fluid_kind = buffer("fluid_kind");
  args.origin = state_.origin;
  args.position = state_.position;
  args.velocity = state_.velocity;
  device_.run(args);
}

std::unique_ptr<Readback> Fluid::sums(std::uint32_t row) {
  if (!watched_) return nullptr;
  device_.enter("density");
  device_.run(kernels::fluid_sum::Args{.threads = kernels::fluid_sum::group_size,
                                       .place_count = plan_.model.places,
                                       .particle_count = plan_.model.count,
                                       .row = row,
                                       .fluid_measure = buffer("fluid_measure"),
                                       .position = state_.position,
                                       .left_out = buffer("near_left_out"),
                                       .fluid_row = buffer("fluid_row")});
  const std::size_t bytes = 8 * element_bytes(Type::real, device_.info().precision);
  return device_.request(buffer("fluid_row"), row * bytes, bytes);
}

} // namespace pliant
