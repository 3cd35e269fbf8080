// Runs the kernels of bonds between fluid particles.
#include "engine/solver/fluid_elastic.h"

#include "engine/solver/fluid.h"
#include "engine/solver/state.h"
#include "engine/solver/stationary.h"
#include "shaders/common/fluid.glsl"
#include "shaders/common/fluid_bond.glsl"
#include "shaders/common/solver.glsl"

#include "kernels/boundary_contact.h"
#include "kernels/chebyshev_step.h"
#include "kernels/fluid_bond_begin.h"
#include "kernels/fluid_bond_carry.h"
#include "kernels/fluid_bond_end.h"
#include "kernels/fluid_bond_fit.h"
#include "kernels/fluid_bond_flow.h"
#include "kernels/fluid_bond_force.h"
#include "kernels/fluid_bond_hold.h"
#include "kernels/fluid_bond_rest.h"
#include "kernels/fluid_bond_return.h"
#include "kernels/fluid_bond_state.h"
#include "kernels/fluid_bond_sum.h"
#include "kernels/fluid_bond_was.h"
#include "kernels/guard_apply.h"
#include "kernels/residual_control.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {

namespace {

constexpr double unyielding = 1e30; ///< Pa; fits a float
// A neighbourhood's directions are few, at surfaces half are missing: the rms over them may be less than that
// over all. With 1.25 some affine states of a jittered block are cut.
constexpr double excess_slack = 2;
constexpr double least_rest = 1e-3, largest_rest = 20; ///< spacings
// Spacings that a particle is redistributed by at most, over the strain that flowed in the step. With more,
// or with all of it, what is moved flows because it is, and a heap of clay never comes to rest.
constexpr double spread_by_flow = 0.25;
// Iterations between looks at the residual.
constexpr unsigned look_every = 4;

} // namespace

void list_bonds(FluidPlan& plan, bool statistics) {
  if (!plan.bonds.any) return;
  const std::size_t places = plan.model.places, sorted = plan.model.sorted(),
                    entries = places * plan.model.rows;
  const bool flows = plan.bonds.flows();
  std::string component;
  const auto buffer = [&](const char* name, Type type, std::size_t count) {
    plan.buffers.push_back({name, type, count, component});
  };
  const auto kernel = [&](const auto& args) { plan.kernels.push_back(kernel_variant(args, component)); };
  component = "bonds";
  buffer("near_count_earlier", Type::uint, places / slice_width);
  buffer("near_earlier", Type::uint, entries);
  buffer("near_rest", Type::real, entries);
  buffer("near_rest_earlier", Type::real, entries);
  buffer("near_place_of", Type::uint, sorted);
  buffer("fluid_was", Type::uint4, places);
  buffer("fluid_fit", Type::real4, 2 * places);
  buffer("fluid_elastic", Type::real4, std::size_t{FLUIDS} * ELASTIC_ROWS);
  kernel(kernels::fluid_bond_was::Args{});
  kernel(kernels::fluid_bond_carry::Args{});
  kernel(kernels::fluid_bond_fit::Args{});
  kernel(kernels::fluid_bond_rest::Args{});
  component = "elasticity";
  for (const char* name :
       {"fluid_target", "fluid_displacement", "fluid_earlier", "fluid_best", "fluid_stay", "fluid_force"})
    buffer(name, Type::real4, places);
  constexpr std::size_t group = kernels::chebyshev_step::group_size;
  buffer("fluid_error", Type::real4, (places + group - 1) / group);
  kernel(kernels::fluid_bond_begin::Args{.plastic = flows});
  kernel(kernels::fluid_bond_state::Args{.plastic = flows});
  kernel(kernels::fluid_bond_force::Args{});
  for (const std::uint32_t checked : {0u, 1u}) kernel(kernels::chebyshev_step::Args{.checked = checked});
  kernel(kernels::residual_control::Args{});
  kernel(kernels::guard_apply::Args{});
  kernel(kernels::fluid_bond_end::Args{});
  if (plan.walls) {
    buffer("fluid_touched", Type::uint, places);
    buffer("fluid_frame", Type::uint, places);    // zeros: all places are in one frame,
    buffer("fluid_frame_origin", Type::real4, 1); // at zero
    kernel(kernels::boundary_contact::Args{.meshes = plan.meshes});
  }
  if (statistics) {
    buffer("fluid_energy", Type::real, places);
    buffer("bond_row", Type::real, bond_columns * statistics_rows);
    kernel(kernels::fluid_bond_sum::Args{.plastic = flows});
    if (!flows) kernel(kernels::fluid_bond_return::Args{.measured = 1});
  }
  if (plan.forces.spread) buffer("fluid_before", Type::real4, places);
  if (flows) {
    component = "plasticity";
    buffer("fluid_flow", Type::real4, 2 * places);
    buffer("fluid_flow_earlier", Type::real4, 2 * places);
    kernel(kernels::fluid_bond_return::Args{.plastic = 1, .measured = statistics});
  }
  if (plan.forces.spread) kernel(kernels::fluid_bond_hold::Args{.plastic = flows});
  if (flows || plan.forces.spread)
    kernel(kernels::fluid_bond_flow::Args{.plastic = flows, .spread = plan.forces.spread});
}

FluidElastic::FluidElastic(Device& device, const Scene& scene, Fluid& fluid, SimulationState& state)
    : device_(device), scene_(scene), fluid_(fluid), state_(state) {
  // Whose bonds are all new knows nothing, and no neighbour asks, but where a list is not that of its
  // neighbours by a rounding.
  std::vector<Real4<double>> nothing;
  for (std::uint32_t i = 0; i < fluid.plan().model.places; ++i)
    nothing.insert(nothing.end(), {{1, 1, 1, 0}, {0, 0, 1, 1}});
  device.upload(fluid.buffer("fluid_fit"), nothing);
}

template <class Args> void FluidElastic::in_lists(Args& args) const {
  args.threads = fluid_.plan().model.places;
  args.rows = fluid_.plan().model.rows;
  args.near_count = fluid_.buffer("near_count");
  args.near = fluid_.buffer("near");
  args.near_rest = fluid_.buffer("near_rest");
}

template <class Args> void FluidElastic::in_space(Args& args) const {
  in_lists(args);
  const Vector3& period = fluid_.plan().model.lattice.period;
  args.period_x = period.x(), args.period_y = period.y(), args.period_z = period.z();
}

template <class Args> void FluidElastic::in_bonds(Args& args) const {
  in_space(args);
  const double reach = fluid_.plan().model.reach;
  const auto& weight = fluid_.plan().bonds.weight;
  args.per_reach2 = 1 / (reach * reach);
  args.weight_0 = weight[0], args.weight_2 = weight[1], args.weight_4 = weight[2];
  args.fluid_start = fluid_.buffer("fluid_start");
}

void FluidElastic::upload_materials(double step) {
  if (step == step_) return;
  step_ = step;
  const FluidPlan& plan = fluid_.plan();
  const double volume = std::pow(plan.model.spacing, plan.model.smoothing.dimension);
  std::vector<Real4<double>> rows(std::size_t{FLUIDS} * ELASTIC_ROWS, {0, 0, 0, 0});
  for (std::size_t m = 0; m < plan.bonds.materials.size(); ++m) {
    const FluidElasticity& e = plan.bonds.materials[m];
    rows[ELASTIC_ROWS * m + ELASTIC_BONDS] = {e.bond, e.volumetric,
                                              e.relaxation > 0 ? std::exp(-step / e.relaxation) : 1, volume};
    rows[ELASTIC_ROWS * m + ELASTIC_YIELD] = {e.surface.shear, e.surface.pressure,
                                              std::min(e.surface.strength, unyielding), e.surface.hardening};
  }
  device_.upload(fluid_.buffer("fluid_elastic"), rows);
}

void FluidElastic::keep_lists() {
  for (const auto& [now, earlier] : {std::pair{"near", "near_earlier"},
                                     {"near_count", "near_count_earlier"},
                                     {"near_rest", "near_rest_earlier"}})
    fluid_.exchange(now, earlier);
  if (fluid_.plan().bonds.flows()) fluid_.exchange("fluid_flow", "fluid_flow_earlier");
}

void FluidElastic::carry() {
  const FluidModel& model = fluid_.plan().model;
  const auto buffer = [&](const char* name) { return fluid_.buffer(name); };
  upload_materials(step_ > 0 ? step_ : 1);
  device_.enter("bonds");
  device_.run(kernels::fluid_bond_was::Args{.threads = model.places,
                                            .particle_count = model.count,
                                            .ghost_count = model.sorted() - model.count,
                                            .fluid_elastic = buffer("fluid_elastic"),
                                            .fluid_particle = buffer("fluid_particle"),
                                            .fluid_kind = buffer("fluid_kind"),
                                            .near_place_of = buffer("near_place_of"),
                                            .fluid_was = buffer("fluid_was")});
  kernels::fluid_bond_carry::Args carry;
  in_lists(carry);
  carry.near_count_earlier = buffer("near_count_earlier");
  carry.near_earlier = buffer("near_earlier");
  carry.near_rest_earlier = buffer("near_rest_earlier");
  carry.fluid_was = buffer("fluid_was");
  carry.near_place_of = buffer("near_place_of");
  device_.run(carry);
  kernels::fluid_bond_fit::Args fit;
  in_bonds(fit);
  fit.excess = excess_slack * std::sqrt(model.smoothing.dimension == 2 ? 2. : 5.);
  fit.fluid_fit = buffer("fluid_fit");
  device_.run(fit);
  kernels::fluid_bond_rest::Args rest;
  in_space(rest);
  rest.least_rest = least_rest * model.spacing;
  rest.fluid_was = buffer("fluid_was");
  rest.fluid_start = buffer("fluid_start");
  rest.fluid_fit = buffer("fluid_fit");
  device_.run(rest);
}

void FluidElastic::forces(bool first) {
  const FluidPlan& plan = fluid_.plan();
  const auto buffer = [&](const char* name) { return fluid_.buffer(name); };
  device_.enter("elasticity");
  if (first || plan.bonds.coupled || plan.bonds.flows()) { // weights are those of the step's start
    kernels::fluid_bond_state::Args state{.plastic = plan.bonds.flows()};
    in_bonds(state);
    state.equivalent = plan.bonds.equivalent;
    state.fluid_elastic = buffer("fluid_elastic");
    state.fluid_displacement = buffer("fluid_displacement");
    state.fluid_flow = buffer("fluid_flow");
    state.fluid_stay = buffer("fluid_stay");
    state.solver = state_.solver;
    device_.run(state);
  }
  kernels::fluid_bond_force::Args force;
  in_bonds(force);
  force.bound = plan.bonds.bound;
  force.fluid_displacement = buffer("fluid_displacement");
  force.fluid_stay = buffer("fluid_stay");
  force.fluid_force = buffer("fluid_force");
  force.solver = state_.solver;
  device_.run(force);
  if (!plan.walls) return;
  device_.enter("boundaries");
  kernels::boundary_contact::Args contact{.threads = plan.model.places, .meshes = plan.meshes};
  contact.obstacles = fluid_.obstacle_count();
  contact.radius = plan.model.spacing / 2;
  contact.obstacle = buffer("obstacle");
  contact.grid = buffer("obstacle_grid");
  contact.position = buffer("fluid_start");
  contact.owner = buffer("fluid_frame");
  contact.origin = buffer("fluid_frame_origin");
  contact.displacement = buffer("fluid_displacement");
  contact.grid_distance = buffer("grid_distance");
  contact.solver = state_.solver;
  contact.force = buffer("fluid_force");
  contact.touched = buffer("fluid_touched");
  contact.least_stiffness = plan.bonds.stiffness * plan.model.constants.front().rest /
                            plan.model.smoothing.lattice_density(plan.model.spacing);
  device_.run(contact);
  device_.enter("elasticity");
}

bool FluidElastic::check(unsigned iteration, double step) {
  const FluidPlan& plan = fluid_.plan();
  const SolverSettings& settings = scene_.solver;
  const double number = plan.bonds.stiffness * step * step;
  const double epsilon = device_.info().precision == Precision::double_precision
                             ? std::numeric_limits<double>::epsilon()
                             : std::numeric_limits<float>::epsilon();
  double mass = 0; // kg, of the heaviest particle
  for (const FluidConstants& c : plan.model.constants)
    mass = std::max(mass, c.rest / plan.model.smoothing.lattice_density(plan.model.spacing));
  // Forces are sums of terms of size K times the spacing, each wrong by one rounding: half an epsilon.
  const double stiffness = plan.bonds.stiffness * mass, diagonal = stiffness + mass / (step * step);
  const double floor = epsilon / 2 * plan.model.spacing * std::sqrt(plan.model.count / diagonal) * stiffness;
  const bool ends = !settings.fixed_iterations;
  // Contacts stiffen the diagonal with what they add, and slide in a layer only: taken as twice the number,
  // as for elastic bodies, or as a reason to accelerate anew whenever one comes or goes, of which a heap has
  // some in each iteration, they cost twice the iterations.
  double gap = chebyshev_gap(number, false, settings.tolerance, settings.iterations);
  if (settings.spectral_radius) gap = std::max(1 - *settings.spectral_radius, 1e-7);
  device_.run(kernels::residual_control::Args{
      .threads = kernels::residual_control::group_size,
      .iteration = iteration,
      .partial_count = static_cast<std::uint32_t>(fluid_.buffer("fluid_error")->count()),
      .restart = iteration == 0,
      .delay = std::min(settings.delay, settings.iterations / 2),
      .accelerate = 1,
      .one_minus_rho = gap,
      .gamma = settings.under_relaxation,
      .tolerance = ends ? settings.tolerance : 0,
      .floor_residual = ends ? floor : 0,
      .rounding = ends ? epsilon / 2 : 0,
      .second_guess = 1,
      .residual_partial = fluid_.buffer("fluid_error"),
      .solver = state_.solver});
  device_.run(kernels::guard_apply::Args{.threads = plan.model.places,
                                         .solver = state_.solver,
                                         .displacement = fluid_.buffer("fluid_displacement"),
                                         .earlier_iterate = fluid_.buffer("fluid_earlier"),
                                         .best_iterate = fluid_.buffer("fluid_best"),
                                         .inertia_target = fluid_.buffer("fluid_target")});
  return ends && device_.download_real(state_.solver, SOLVER_STOP, 1)[0] == 1;
}

void FluidElastic::solve(double step) {
  const FluidPlan& plan = fluid_.plan();
  const auto buffer = [&](const char* name) { return fluid_.buffer(name); };
  device_.enter("elasticity");
  upload_materials(step);
  device_.run(kernels::fluid_bond_begin::Args{.threads = plan.model.places,
                                              .plastic = plan.bonds.flows(),
                                              .time_step = step,
                                              .fluid_elastic = buffer("fluid_elastic"),
                                              .fluid_place = buffer("fluid_place"),
                                              .fluid_velocity = buffer("fluid_velocity"),
                                              .fluid_was = buffer("fluid_was"),
                                              .fluid_flow_earlier = buffer("fluid_flow_earlier"),
                                              .fluid_target = buffer("fluid_target"),
                                              .fluid_displacement = buffer("fluid_displacement"),
                                              .fluid_stay = buffer("fluid_stay"),
                                              .fluid_flow = buffer("fluid_flow")});
  device_.upload(state_.solver, std::vector<double>(SOLVER_ENTRIES, 0.0)); // the last solve's flag is up
  device_.copy(buffer("fluid_displacement"), buffer("fluid_earlier"));
  device_.copy(buffer("fluid_displacement"), buffer("fluid_best"));
  const unsigned cap = scene_.solver.iterations;
  for (unsigned k = 0; k <= cap; ++k) {
    const bool checked = k <= 1 || k % look_every == 0 || k == cap;
    forces(k == 0);
    device_.run(kernels::chebyshev_step::Args{.threads = plan.model.places,
                                              .checked = checked,
                                              .iteration = k,
                                              .inertia_target = buffer("fluid_target"),
                                              .force = buffer("fluid_force"),
                                              .displacement = buffer("fluid_displacement"),
                                              .earlier_iterate = buffer("fluid_earlier"),
                                              .solver = state_.solver,
                                              .residual_partial = buffer("fluid_error")});
    fluid_.exchange("fluid_displacement", "fluid_earlier");
    if (checked && check(k, step)) break;
  }
  device_.run(kernels::fluid_bond_end::Args{.threads = plan.model.places,
                                            .time_step = step,
                                            .fluid_start = buffer("fluid_start"),
                                            .fluid_best = buffer("fluid_best"),
                                            .fluid_velocity = buffer("fluid_velocity"),
                                            .fluid_place = buffer("fluid_place")});
}

void FluidElastic::settle(bool measured) {
  const FluidPlan& plan = fluid_.plan();
  const auto buffer = [&](const char* name) { return fluid_.buffer(name); };
  if (plan.bonds.flows() || measured) {
    device_.enter(plan.bonds.flows() ? "plasticity" : "elasticity");
    kernels::fluid_bond_return::Args args{.plastic = plan.bonds.flows(), .measured = measured};
    in_bonds(args);
    args.equivalent = plan.bonds.equivalent;
    args.dimension = plan.model.smoothing.dimension;
    args.fluid_elastic = buffer("fluid_elastic");
    args.fluid_place = buffer("fluid_place");
    args.fluid_stay = buffer("fluid_stay");
    args.fluid_flow = buffer("fluid_flow");
    args.fluid_energy = buffer("fluid_energy");
    device_.run(args);
  }
  if (plan.forces.spread) device_.copy(buffer("fluid_place"), buffer("fluid_before"));
}

void FluidElastic::hold() {
  const FluidPlan& plan = fluid_.plan();
  if (!plan.forces.spread) return;
  device_.enter(plan.bonds.flows() ? "plasticity" : "elasticity");
  device_.run(kernels::fluid_bond_hold::Args{.threads = plan.model.places,
                                             .plastic = plan.bonds.flows(),
                                             .rate = spread_by_flow * plan.model.spacing,
                                             .fluid_before = fluid_.buffer("fluid_before"),
                                             .fluid_stay = fluid_.buffer("fluid_stay"),
                                             .fluid_flow = fluid_.buffer("fluid_flow"),
                                             .fluid_place = fluid_.buffer("fluid_place")});
}

void FluidElastic::flow() {
  const FluidPlan& plan = fluid_.plan();
  if (!plan.bonds.flows() && !plan.forces.spread) return;
  device_.enter(plan.bonds.flows() ? "plasticity" : "elasticity");
  kernels::fluid_bond_flow::Args args{.plastic = plan.bonds.flows(), .spread = plan.forces.spread};
  in_space(args);
  args.least_rest = least_rest * plan.model.spacing;
  args.largest_rest = largest_rest * plan.model.spacing;
  args.fluid_before = fluid_.buffer(plan.forces.spread ? "fluid_before" : "fluid_place");
  args.fluid_place = fluid_.buffer("fluid_place");
  args.fluid_flow = fluid_.buffer("fluid_flow");
  args.fluid_was = fluid_.buffer("fluid_was");
  device_.run(args);
}

std::unique_ptr<Readback> FluidElastic::sums(std::uint32_t row) {
  const FluidPlan& plan = fluid_.plan();
  device_.enter(plan.bonds.flows() ? "plasticity" : "elasticity");
  device_.run(kernels::fluid_bond_sum::Args{.threads = kernels::fluid_bond_sum::group_size,
                                            .plastic = plan.bonds.flows(),
                                            .place_count = plan.model.places,
                                            .row = row,
                                            .fluid_flow = fluid_.buffer("fluid_flow"),
                                            .fluid_energy = fluid_.buffer("fluid_energy"),
                                            .bond_row = fluid_.buffer("bond_row")});
  const std::size_t bytes = bond_columns * element_bytes(Type::real, device_.info().precision);
  return device_.request(fluid_.buffer("bond_row"), row * bytes, bytes);
}

std::vector<double> FluidElastic::plastic_strain() const {
  const std::vector<Real4<double>> flow = device_.download_real4(fluid_.buffer("fluid_flow"));
  const std::vector<std::uint32_t> place = device_.download_uint(fluid_.buffer("near_place_of"));
  std::vector<double> strain(fluid_.plan().model.count);
  for (std::size_t i = 0; i < strain.size(); ++i) strain[i] = flow[2 * std::size_t{place[i]}].x;
  return strain;
}

} // namespace pliant
