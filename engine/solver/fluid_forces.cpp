// Runs the kernels of viscosity, redistribution and surface tension.
#include "engine/solver/fluid_forces.h"

#include "engine/solver/fluid.h"
#include "engine/solver/motion.h"
#include "engine/solver/state.h"
#include "shaders/common/fluid.glsl"
#include "shaders/common/fluid_viscosity.glsl"

#include "kernels/fluid_ghost_cell.h"
#include "kernels/fluid_ghost_gather.h"
#include "kernels/fluid_gradient.h"
#include "kernels/fluid_gradient_sum.h"
#include "kernels/fluid_newton.h"
#include "kernels/fluid_redistribute.h"
#include "kernels/fluid_viscosity_apply.h"
#include "kernels/fluid_viscosity_begin.h"
#include "kernels/fluid_viscosity_control.h"
#include "kernels/fluid_viscosity_product.h"
#include "kernels/fluid_viscosity_update.h"

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

// Of the gradient, in squares of the support, of redistribution 1. At .2 a jittered block gets worse instead
// of better.
constexpr double fickian_rate = 0.1;
// Of Newton's step, of redistribution 1: neighbours answer the same unevenness at once, from .3 on too
// strongly.
constexpr double newton_rate = 0.2;
// Of a particle in one sweep, spacings.
constexpr double largest_shift = 0.1;
// Share of a full lattice's denominator of tau, over |g|^2.
constexpr double newton_softness = 1e-3;
// Eq. 24 lacks a factor of 1/m^2. With this one over the squared spacing its steps are as long as Newton's.
constexpr double printed_rate = 2;
// Nearer to a wall than this many spacings, what sticks to it feels no more of it.
constexpr double least_wall_distance = 0.25;
// Iterations of viscosity between looks at whether they have ended.
constexpr unsigned look_every = 4;

template <class Args> void in_lists(Args& args, const Fluid& fluid) {
  const FluidModel& model = fluid.plan().model;
  args.rows = model.rows;
  args.near_count = fluid.buffer("near_count");
  args.near = fluid.buffer("near");
}

template <class Args> void in_periods(Args& args, const FluidModel& model) {
  args.period_x = model.lattice.period.x();
  args.period_y = model.lattice.period.y();
  args.period_z = model.lattice.period.z();
}

template <class Args> void in_space(Args& args, const Fluid& fluid) {
  const FluidModel& model = fluid.plan().model;
  in_lists(args, fluid);
  in_periods(args, model);
  args.support = model.smoothing.support;
  args.fluid_place = fluid.buffer("fluid_place");
}

bool stands(const Motion& motion) {
  return motion.rate == 0 && motion.velocity.isZero(0) && !motion.release.value_or(false);
}

} // namespace

FluidForcePlan plan_forces(const Scene& scene, const Model& model, const FluidModel& fluid) {
  FluidForcePlan plan;
  plan.ghosts = !fluid.ghosts.empty();
  for (const FluidConstants& c : fluid.constants) {
    plan.viscous = plan.viscous || c.viscosity > 0;
    plan.viscosities = plan.viscosities || c.viscosity != fluid.constants.front().viscosity;
    plan.spread = plan.spread || c.redistribution > 0 || c.surface_tension > 0;
    plan.tension = plan.tension || c.surface_tension > 0;
  }
  plan.central = plan.viscous && scene.fluid.viscosity_form == "central";
  plan.spread = plan.spread && scene.fluid.redistribution_iterations > 0;
  plan.tension = plan.tension && plan.spread;
  for (std::uint32_t i = fluid.first; i < fluid.first + fluid.count; ++i)
    plan.masses = plan.masses || model.mass[i] != model.mass[fluid.first];
  const std::string& form = scene.fluid.redistribution_form;
  plan.form = form == "fickian" ? 0 : form == "newton" ? 1 : 2;
  plan.sign = form == "negated" ? -1 : 1;
  return plan;
}

void list_forces(const FluidForcePlan& plan, const FluidModel& fluid, bool statistics,
                 std::vector<BufferSpec>& buffers, std::vector<KernelSpec>& kernels) {
  const std::size_t places = fluid.places, rates = places * fluid.rows;
  std::string component;
  const auto buffer = [&](const char* name, Type type, std::size_t count) {
    buffers.push_back({name, type, count, component});
  };
  const auto kernel = [&](const auto& args) { kernels.push_back(kernel_variant(args, component)); };
  if (plan.ghosts) {
    component = "ghosts";
    buffer("ghost_place", Type::real4, fluid.ghosts.size());
    buffer("ghost_velocity", Type::real4, fluid.ghosts.size());
    kernel(kernels::fluid_ghost_cell::Args{});
    kernel(kernels::fluid_ghost_gather::Args{});
  }
  if (plan.viscous) {
    component = "viscosity";
    buffer("near_rate", Type::real, rates);
    buffer("fluid_residual", Type::real4, places);
    buffer("fluid_image", Type::real4, places);
    buffer("fluid_direction", Type::real4, places);
    buffer("fluid_direction_image", Type::real4, places);
    constexpr std::size_t group = kernels::fluid_viscosity_product::group_size;
    buffer("fluid_partial", Type::real4, (places + group - 1) / group);
    buffer("fluid_viscosity", Type::real, VISCOSITY_ENTRIES);
    kernel(kernels::fluid_viscosity_begin::Args{
        .ghosts = plan.ghosts, .mixed = plan.viscosities, .central = plan.central});
    kernel(kernels::fluid_viscosity_control::Args{.start = 1});
    kernel(kernels::fluid_viscosity_product::Args{.central = plan.central});
    kernel(kernels::fluid_viscosity_control::Args{});
    kernel(kernels::fluid_viscosity_update::Args{});
    kernel(kernels::fluid_viscosity_apply::Args{});
  }
  if (plan.spread) {
    component = "redistribution";
    buffer("fluid_shift", Type::real4, places);
    buffer("fluid_gradient", Type::real4, places);
    buffer("fluid_normal", Type::real4, places);
    kernel(kernels::fluid_gradient::Args{.fickian = plan.form == 0, .tension = plan.tension});
    if (plan.form > 0) {
      buffer("fluid_newton", Type::real4, places);
      kernel(kernels::fluid_newton::Args{});
    }
    kernel(
        kernels::fluid_redistribute::Args{.form = plan.form, .tension = plan.tension, .mixed = plan.masses});
  }
  if (statistics && (plan.spread || plan.viscous)) {
    component = plan.spread ? "redistribution" : "viscosity";
    buffer("spread_row", Type::real, spread_columns * statistics_rows);
    kernel(kernels::fluid_gradient_sum::Args{.spread = plan.spread, .viscous = plan.viscous});
  }
}

FluidForces::FluidForces(Device& device, const Scene& scene, const Fluid& fluid, const Vector3& origin)
    : device_(device), scene_(scene), fluid_(fluid), origin_(origin) {
  for (const FluidConstants& c : fluid_.plan().model.constants) {
    const double mass = c.rest / fluid_.plan().model.smoothing.lattice_density(fluid_.plan().model.spacing);
    ghost_mass_ = ghost_mass_ > 0 ? std::min(ghost_mass_, mass) : mass;
  }
}

void FluidForces::move_ghosts(double begin, double end) {
  const std::vector<Ghost>& ghosts = fluid_.plan().model.ghosts;
  if (ghosts.empty() || ghosts_stand_) return;
  ghosts_stand_ = std::all_of(scene_.boundaries.begin(), scene_.boundaries.end(),
                              [](const Boundary& b) { return b.slip || stands(b.motion); });
  const Vector3& period = fluid_.plan().model.lattice.period;
  std::vector<Real4<double>> place, velocity;
  for (const Ghost& ghost : ghosts) {
    const Motion& motion = scene_.boundaries[ghost.boundary].motion;
    const Vector3 was = motion_at(motion, begin)(ghost.place), now = motion_at(motion, end)(ghost.place);
    const Vector3 v = end > begin ? Vector3((now - was) / (end - begin)) : Vector3::Zero();
    Vector3 at = now - origin_;
    for (int a = 0; a < 3; ++a) // distances look for images in the next period only
      if (period[a] > 0) at[a] -= period[a] * std::floor(at[a] / period[a]);
    place.push_back({at.x(), at.y(), at.z(), released(motion, end) ? 0 : -ghost_mass_});
    velocity.push_back({v.x(), v.y(), v.z(), -ghost.depth});
  }
  device_.upload(fluid_.buffer("ghost_place"), place);
  device_.upload(fluid_.buffer("ghost_velocity"), velocity);
}

void FluidForces::sort_ghosts() {
  const FluidModel& model = fluid_.plan().model;
  if (model.ghosts.empty()) return;
  device_.run(kernels::fluid_ghost_cell::Args{.threads = static_cast<std::uint32_t>(model.ghosts.size()),
                                              .particle_count = model.count,
                                              .per_cell_x = 1 / model.lattice.edge.x(),
                                              .per_cell_y = 1 / model.lattice.edge.y(),
                                              .per_cell_z = 1 / model.lattice.edge.z(),
                                              .cells_x = model.lattice.cells[0],
                                              .cells_y = model.lattice.cells[1],
                                              .cells_z = model.lattice.cells[2],
                                              .ghost_place = fluid_.buffer("ghost_place"),
                                              .cell_of = fluid_.buffer("near_cell_of"),
                                              .cell_count = fluid_.buffer("near_cell_count")});
}

void FluidForces::gather_ghosts() {
  const FluidModel& model = fluid_.plan().model;
  if (model.ghosts.empty()) return;
  device_.run(
      kernels::fluid_ghost_gather::Args{.threads = model.sorted(),
                                        .particle_count = model.count,
                                        .ghost_count = static_cast<std::uint32_t>(model.ghosts.size()),
                                        .fluid_particle = fluid_.buffer("fluid_particle"),
                                        .ghost_place = fluid_.buffer("ghost_place"),
                                        .ghost_velocity = fluid_.buffer("ghost_velocity"),
                                        .fluid_place = fluid_.buffer("fluid_place"),
                                        .fluid_velocity = fluid_.buffer("fluid_velocity"),
                                        .fluid_start = fluid_.buffer("fluid_start")});
}

void FluidForces::viscosity(double step) {
  const FluidForcePlan& plan = fluid_.plan().forces;
  if (!plan.viscous) return;
  const FluidModel& model = fluid_.plan().model;
  const std::uint32_t places = model.places;
  const auto buffer = [&](const char* name) { return fluid_.buffer(name); };
  device_.enter("viscosity");
  kernels::fluid_viscosity_begin::Args begin{
      .threads = places, .ghosts = plan.ghosts, .mixed = plan.viscosities, .central = plan.central};
  in_space(begin, fluid_);
  const double volume = std::pow(model.spacing, model.smoothing.dimension);
  const double lattice = plan.central ? model.smoothing.lattice_central_viscosity(model.spacing)
                                      : model.smoothing.lattice_viscosity(model.spacing);
  begin.coupling = step * volume * volume * model.smoothing.viscous() / lattice;
  begin.least_distance = least_wall_distance * model.spacing;
  begin.fluid_material = buffer("fluid_material");
  begin.fluid_velocity = buffer("fluid_velocity");
  begin.fluid_start = buffer("fluid_start");
  begin.near_rate = buffer("near_rate");
  begin.fluid_residual = buffer("fluid_residual");
  begin.fluid_partial = buffer("fluid_partial");
  device_.run(begin);
  kernels::fluid_viscosity_control::Args control{.threads = kernels::fluid_viscosity_control::group_size,
                                                 .start = 1};
  constexpr std::uint32_t group = kernels::fluid_viscosity_product::group_size;
  control.partial_count = (places + group - 1) / group;
  control.cap = scene_.fluid.viscosity_iterations;
  control.tolerance = scene_.fluid.viscosity_tolerance;
  control.rounding = device_.info().precision == Precision::double_precision ? 0x1p-50 : 0x1p-21;
  control.fluid_partial = buffer("fluid_partial");
  control.fluid_viscosity = buffer("fluid_viscosity");
  device_.run(control);
  control.start = 0;
  kernels::fluid_viscosity_product::Args product{.threads = places, .central = plan.central};
  in_lists(product, fluid_);
  in_periods(product, model);
  product.near_rate = buffer("near_rate");
  product.fluid_residual = buffer("fluid_residual");
  product.fluid_viscosity = buffer("fluid_viscosity");
  product.fluid_start = buffer("fluid_start");
  product.fluid_image = buffer("fluid_image");
  product.fluid_partial = buffer("fluid_partial");
  const kernels::fluid_viscosity_update::Args update{.threads = places,
                                                     .fluid_viscosity = buffer("fluid_viscosity"),
                                                     .fluid_image = buffer("fluid_image"),
                                                     .fluid_direction = buffer("fluid_direction"),
                                                     .fluid_direction_image = buffer("fluid_direction_image"),
                                                     .fluid_residual = buffer("fluid_residual"),
                                                     .fluid_velocity = buffer("fluid_velocity")};
  for (unsigned k = 0; k <= scene_.fluid.viscosity_iterations; ++k) {
    device_.run(product);
    device_.run(control);
    device_.run(update); // does nothing once they have ended, so that it is all the same when one looks
    if (k % look_every == look_every - 1 &&
        device_.download_real(buffer("fluid_viscosity"), VISCOSITY_STOP, 1)[0] > 0)
      break;
  }
  device_.run(kernels::fluid_viscosity_apply::Args{.threads = places,
                                                   .time_step = step,
                                                   .fluid_start = buffer("fluid_start"),
                                                   .fluid_velocity = buffer("fluid_velocity"),
                                                   .fluid_place = buffer("fluid_place")});
}

void FluidForces::spread() {
  const FluidForcePlan& plan = fluid_.plan().forces;
  const FluidModel& model = fluid_.plan().model;
  const Smoothing& smoothing = model.smoothing;
  const double support = smoothing.support, d = smoothing.dimension;
  const double volume = std::pow(model.spacing, d), spiky = volume * smoothing.spiky_gradient();
  const auto buffer = [&](const char* name) { return fluid_.buffer(name); };
  device_.enter("redistribution");
  kernels::fluid_gradient::Args gradient{
      .threads = model.places, .fickian = plan.form == 0, .tension = plan.tension};
  in_space(gradient, fluid_);
  gradient.spiky_scale = spiky;
  gradient.normal_scale = support * volume * smoothing.spline_gradient();
  const double cover = smoothing.lattice_sum(
      model.spacing, [&](double r) { return r > 0 ? -r * smoothing.spline_derivative(r) : 0; });
  gradient.cover_scale = smoothing.spline_gradient() / cover;
  gradient.rate = fickian_rate * support * support;
  gradient.limit = largest_shift * model.spacing;
  gradient.fluid_material = buffer("fluid_material");
  gradient.fluid_velocity = buffer("fluid_velocity");
  gradient.fluid_gradient = buffer("fluid_gradient");
  gradient.fluid_normal = buffer("fluid_normal");
  device_.run(gradient);
  if (plan.form > 0) {
    kernels::fluid_newton::Args newton{.threads = model.places};
    in_space(newton, fluid_);
    newton.slope_scale = newton.curvature_scale = spiky;
    // Of a unit vector e on the lattice: |sum_j H_ij e|^2 + sum_j |H_ij e|^2, in the mean over directions.
    const auto slope = [&](double r) { return volume * smoothing.spiky_derivative(r) / r; };
    const auto curvature = [&](double r) { return 6 * spiky * (1 - r / support); };
    const double sum = smoothing.lattice_sum(
        model.spacing, [&](double r) { return r > 0 ? (curvature(r) + (d - 1) * slope(r)) / d : 0; });
    const double squares = smoothing.lattice_sum(model.spacing, [&](double r) {
      return r > 0 ? (std::pow(curvature(r), 2) + (d - 1) * std::pow(slope(r), 2)) / d : 0;
    });
    newton.softness = newton_softness * (sum * sum + squares);
    newton.rate = newton_rate;
    newton.limit = gradient.limit;
    newton.fluid_gradient = buffer("fluid_gradient");
    newton.fluid_normal = buffer("fluid_normal");
    newton.fluid_newton = buffer("fluid_newton");
    device_.run(newton);
  }
  kernels::fluid_redistribute::Args shift{
      .threads = model.places, .form = plan.form, .tension = plan.tension, .mixed = plan.masses};
  in_space(shift, fluid_);
  shift.spacing = model.spacing;
  shift.slope_scale = shift.curvature_scale = spiky;
  shift.rate = plan.form == 2 ? plan.sign * printed_rate / (model.spacing * model.spacing) : gradient.rate;
  shift.pull = model.spacing / scene_.fluid.redistribution_iterations; // all sweeps of a step together
  shift.fluid_material = buffer("fluid_material");
  shift.fluid_gradient = buffer("fluid_gradient");
  shift.fluid_normal = buffer("fluid_normal");
  shift.fluid_newton = buffer("fluid_newton");
  shift.fluid_velocity = buffer("fluid_velocity");
  shift.fluid_shift = buffer("fluid_shift");
  device_.run(shift);
}

std::unique_ptr<Readback> FluidForces::sums(std::uint32_t row) {
  const FluidForcePlan& plan = fluid_.plan().forces;
  if (!fluid_.buffer("spread_row")) return nullptr;
  device_.enter(plan.spread ? "redistribution" : "viscosity");
  device_.run(kernels::fluid_gradient_sum::Args{.threads = kernels::fluid_gradient_sum::group_size,
                                                .spread = plan.spread,
                                                .viscous = plan.viscous,
                                                .place_count = fluid_.plan().model.places,
                                                .row = row,
                                                .support = fluid_.plan().model.smoothing.support,
                                                .fluid_gradient = fluid_.buffer("fluid_gradient"),
                                                .fluid_normal = fluid_.buffer("fluid_normal"),
                                                .fluid_viscosity = fluid_.buffer("fluid_viscosity"),
                                                .spread_row = fluid_.buffer("spread_row")});
  const std::size_t bytes = spread_columns * element_bytes(Type::real, device_.info().precision);
  return device_.request(fluid_.buffer("spread_row"), row * bytes, bytes);
}

} // namespace pliant
