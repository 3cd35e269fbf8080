// Allocates and runs contacts.
#include "engine/solver/contact.h"

#include "engine/core/error.h"
#include "shaders/common/contact.glsl"

#include "kernels/boundary_contact.h"
#include "kernels/contact_find.h"
#include "kernels/contact_force.h"
#include "kernels/contact_mutual.h"
#include "kernels/contact_product.h"
#include "kernels/contact_start.h"
#include "kernels/grid_clear.h"
#include "kernels/grid_count.h"
#include "kernels/grid_place.h"
#include "kernels/grid_scan.h"
#include "kernels/grid_sort.h"
#include "kernels/grid_sum.h"
#include "kernels/grid_totals.h"

#include <algorithm>
#include <bit>

namespace pliant {

namespace {

// How much further than the contact distance lists reach, in spacings. More lets find() run less often and
// costs candidates with its cube.
constexpr double margin_spacings = 0.3;
// Cells are a little wider than the reach, so that rounding cannot part two particles by two cells.
constexpr double cell_slack = 1.001;

constexpr const char* component = "contacts";
constexpr const char* boundary_component = "boundaries";

double grid_cell(const Scene& scene) {
  return scene.simulation.spacing;
}

// In the table of obstacles something changes with time.
bool moves(const Boundary& boundary) {
  const Motion& motion = boundary.motion;
  return motion.rate != 0 || !motion.velocity.isZero(0) || motion.release.value_or(false);
}

} // namespace

ContactUse contact_use(const Method& method) {
  return {.potential = method.potential, .tangent = method.name == "newton"};
}

ContactPlan plan_contacts(const Scene& scene, const Model& model, ContactUse use) {
  ContactPlan plan;
  plan.use = use;
  const std::size_t n = model.count();
  if (n == 0) return plan;
  plan.particles = static_cast<std::uint32_t>(n);
  plan.radius = model.spacing / 2;
  plan.distance = scene.contact.distance * model.spacing;
  plan.reach = plan.distance + margin_spacings * model.spacing;
  plan.boundaries = !scene.boundaries.empty();
  plan.between = scene.contact.bodies && model.bodies.size() > 1;
  plan.within = scene.contact.self && std::any_of(model.bodies.begin(), model.bodies.end(),
                                                  [](const BodyModel& body) { return body.self_contact; });
  const auto kernel = [&](const auto& args, const char* where) {
    plan.kernels.push_back(kernel_variant(args, where));
  };
  const auto buffer = [&](const char* name, Type type, std::size_t count, const char* where) {
    plan.buffers.push_back({name, type, count, where});
  };
  for (const char* where : {boundary_component, component}) {
    if (where == component ? !plan.pairs() : !plan.boundaries) continue;
    buffer("touched", Type::uint, n, where);
    if (!plan.started()) continue;
    buffer("contact_start", Type::real4, n, where);
    kernel(kernels::contact_start::Args{}, where);
  }
  if (plan.boundaries) {
    const Obstacles obstacles(scene, plan.radius, grid_cell(scene), true);
    plan.meshes = obstacles.meshes();
    buffer("obstacle", Type::real4, std::size_t{OBSTACLES} * OBSTACLE_ROWS, boundary_component);
    if (plan.meshes) {
      buffer("obstacle_grid", Type::uint4, OBSTACLES, boundary_component);
      buffer("grid_distance", Type::real, obstacles.grid_nodes(), boundary_component);
    }
    if (use.tangent) buffer("contact_block", Type::real4, 2 * n, boundary_component);
    kernel(kernels::boundary_contact::Args{.meshes = plan.meshes,
                                           .potential = use.potential,
                                           .tangent = use.tangent},
           boundary_component);
  }
  if (plan.pairs()) {
    plan.cells = std::bit_ceil(std::max(plan.particles, 256u));
    plan.chunks = (plan.cells + SCAN_CHUNK - 1) / SCAN_CHUNK;
    buffer("cell_count", Type::uint, plan.cells, component);
    buffer("chunk_begin", Type::uint, plan.chunks, component);
    buffer("cell_begin", Type::uint, std::size_t{plan.cells} + 1, component);
    buffer("cell_of", Type::uint, n, component);
    buffer("placed", Type::uint, n, component);
    buffer("sorted", Type::uint, n, component);
    buffer("sorted_place", Type::real4, n, component);
    buffer("contact", Type::uint, (n + slice_width - 1) / slice_width * slice_width * CONTACTS, component);
    buffer("left_out", Type::uint, 2, component);
    if (plan.within) {
      buffer("self_contact", Type::uint, model.bodies.size(), component);
      buffer("law_range", Type::uint4, 4, component);
    }
    kernel(kernels::grid_clear::Args{}, component);
    kernel(kernels::grid_count::Args{}, component);
    kernel(kernels::grid_sum::Args{}, component);
    kernel(kernels::grid_totals::Args{}, component);
    kernel(kernels::grid_scan::Args{}, component);
    kernel(kernels::grid_place::Args{}, component);
    kernel(kernels::grid_sort::Args{}, component);
    kernel(kernels::contact_find::Args{.between = plan.between, .within = plan.within}, component);
    kernel(kernels::contact_mutual::Args{}, component);
    kernel(kernels::contact_force::Args{.alone = !plan.boundaries, .potential = use.potential}, component);
    if (use.tangent) kernel(kernels::contact_product::Args{}, component);
  }
  return plan;
}

Contacts::Contacts(Device& device, const Scene& scene, const Model& model, const Vector3& scene_origin,
                   ContactUse use)
    : device_(device), plan_(plan_contacts(scene, model, use)),
      obstacles_(scene, plan_.radius, grid_cell(scene)), origin_(scene_origin) {
  for (const BufferSpec& spec : plan_.buffers)
    if (!buffers_.count(spec.name))
      buffers_.emplace(spec.name, device.allocate(spec.name, spec.type, spec.count));
  if (!plan_.any()) return;
  friction_ = scene.contact.friction;
  lightest_ = *std::min_element(model.mass.begin(), model.mass.end());
  if (plan_.meshes) {
    device.upload(buffer("obstacle_grid"), obstacles_.grid_table());
    device.upload(buffer("grid_distance"), obstacles_.take_distances());
  }
  if (std::none_of(scene.boundaries.begin(), scene.boundaries.end(), moves) && plan_.boundaries) {
    device.upload(buffer("obstacle"), obstacles_.table(0, 0, origin_));
    still_ = true;
  }
  for (const BodyModel& body : model.bodies) base_ += (body.origin - origin_) / double(model.bodies.size());
  if (!plan_.within) return;
  std::vector<std::uint32_t> self, ranges(16, 0);
  for (const BodyModel& body : model.bodies) self.push_back(body.self_contact);
  if (model.laws.size() > 4) throw Error(ExitCode::internal, "contacts know at most four ranges of laws");
  for (std::size_t r = 0; r < model.laws.size(); ++r) {
    ranges[4 * r] = model.laws[r].first;
    ranges[4 * r + 1] = model.laws[r].count;
    ranges[4 * r + 2] = model.laws[r].first_slice;
  }
  device.upload(buffer("self_contact"), self);
  device.upload(buffer("law_range"), ranges);
}

BufferStorage* Contacts::buffer(const std::string& name) const {
  const auto found = buffers_.find(name);
  return found == buffers_.end() ? nullptr : static_cast<BufferStorage*>(found->second);
}

namespace {

kernels::boundary_contact::Args boundary_args(const Contacts& contacts, const ContactState& state,
                                              std::uint32_t obstacles, const Vector3& base,
                                              double least_stiffness) {
  kernels::boundary_contact::Args args;
  args.threads = contacts.plan().particles;
  args.meshes = contacts.plan().meshes;
  args.potential = contacts.plan().use.potential;
  args.tangent = contacts.plan().use.tangent;
  args.obstacles = obstacles;
  args.radius = contacts.plan().radius;
  args.least_stiffness = least_stiffness;
  args.base_x = base[0];
  args.base_y = base[1];
  args.base_z = base[2];
  args.obstacle = contacts.buffer("obstacle");
  args.grid = contacts.buffer("obstacle_grid");
  args.start = contacts.buffer("contact_start");
  args.position = state.position;
  args.owner = state.owner;
  args.origin = state.origin;
  args.displacement = state.displacement;
  args.grid_distance = contacts.buffer("grid_distance");
  args.solver = state.solver;
  args.force = state.force;
  args.touched = contacts.touched();
  args.energy = state.energy;
  args.contact_block = contacts.block();
  return args;
}

kernels::contact_force::Args force_args(const Contacts& contacts, const ContactState& state,
                                        double friction) {
  kernels::contact_force::Args args;
  args.threads = contacts.plan().particles;
  args.alone = !contacts.plan().boundaries;
  args.potential = contacts.plan().use.potential;
  args.contact_distance = contacts.plan().distance;
  args.friction = friction;
  args.contact = contacts.buffer("contact");
  args.start = contacts.buffer("contact_start");
  args.displacement = state.displacement;
  args.solver = state.solver;
  args.force = state.force;
  args.touched = contacts.touched();
  args.energy = state.energy;
  return args;
}

kernels::contact_product::Args product_args(const Contacts& contacts, const ContactState& state,
                                            double friction, BufferStorage* displacement,
                                            BufferStorage* direction) {
  kernels::contact_product::Args args;
  args.threads = contacts.plan().particles;
  args.contact_distance = contacts.plan().distance;
  args.friction = friction;
  args.contact = contacts.buffer("contact");
  args.start = contacts.buffer("contact_start");
  args.displacement = displacement;
  args.direction = direction;
  args.solver = state.solver;
  args.force = state.force;
  return args;
}

} // namespace

// The kernels of find(), in order.
template <class Visit> void Contacts::each_kernel(const ContactState& state, Visit visit) {
  const double per_cell = 1 / (cell_slack * plan_.reach);
  const std::uint32_t n = plan_.particles;
  kernels::grid_clear::Args clear;
  clear.threads = plan_.cells;
  clear.cell_count = buffer("cell_count");
  clear.left_out = buffer("left_out");
  visit(clear);
  kernels::grid_count::Args count;
  count.threads = n;
  count.per_cell = per_cell;
  count.mask = plan_.cells - 1;
  count.start = buffer("contact_start");
  count.displacement = state.displacement;
  count.cell_of = buffer("cell_of");
  count.cell_count = buffer("cell_count");
  visit(count);
  kernels::grid_sum::Args sum;
  sum.threads = 256 * plan_.chunks;
  sum.cells = plan_.cells;
  sum.cell_count = buffer("cell_count");
  sum.chunk_begin = buffer("chunk_begin");
  visit(sum);
  kernels::grid_totals::Args totals;
  totals.threads = 256;
  totals.chunks = plan_.chunks;
  totals.chunk_begin = buffer("chunk_begin");
  visit(totals);
  kernels::grid_scan::Args scan;
  scan.threads = 256 * plan_.chunks;
  scan.cells = plan_.cells;
  scan.chunk_begin = buffer("chunk_begin");
  scan.cell_count = buffer("cell_count");
  scan.cell_begin = buffer("cell_begin");
  visit(scan);
  kernels::grid_place::Args place;
  place.threads = n;
  place.cell_of = buffer("cell_of");
  place.cell_next = buffer("cell_count");
  place.placed = buffer("placed");
  visit(place);
  kernels::grid_sort::Args sort;
  sort.threads = n;
  sort.cells = plan_.cells;
  sort.cell_begin = buffer("cell_begin");
  sort.cell_of = buffer("cell_of");
  sort.placed = buffer("placed");
  sort.owner = state.owner;
  sort.start = buffer("contact_start");
  sort.displacement = state.displacement;
  sort.sorted = buffer("sorted");
  sort.sorted_place = buffer("sorted_place");
  visit(sort);
  kernels::contact_find::Args near;
  near.threads = n;
  near.between = plan_.between;
  near.within = plan_.within;
  near.per_cell = per_cell;
  near.mask = plan_.cells - 1;
  near.reach = plan_.reach;
  near.law_range = buffer("law_range");
  near.cell_begin = buffer("cell_begin");
  near.sorted = buffer("sorted");
  near.sorted_place = buffer("sorted_place");
  near.slice_begin = state.slice_begin;
  near.bond = state.bond;
  near.self_contact = buffer("self_contact");
  near.contact = buffer("contact");
  near.left_out = buffer("left_out");
  visit(near);
  kernels::contact_mutual::Args mutual;
  mutual.threads = n;
  mutual.left_out = buffer("left_out");
  mutual.contact = buffer("contact");
  visit(mutual);
}

void Contacts::prepare() {
  const ContactState none;
  const auto compile = [&](const auto& args) { device_.prepare(args.info(), &args); };
  if (plan_.started()) compile(kernels::contact_start::Args{});
  if (plan_.boundaries) compile(boundary_args(*this, none, 0, base_, 0));
  if (!plan_.pairs()) return;
  each_kernel(none, compile);
  compile(force_args(*this, none, friction_));
  if (plan_.use.tangent) compile(product_args(*this, none, friction_, nullptr, nullptr));
}

void Contacts::begin_step(double time, double step, const ContactState& state) {
  if (!plan_.any()) return;
  if (plan_.boundaries && !still_) {
    device_.enter(boundary_component);
    device_.upload(buffer("obstacle"), obstacles_.table(time, time + step, origin_));
  }
  least_stiffness_ = lightest_ / (step * step); // of particles without bonds
  if (!plan_.started()) return;
  device_.enter(plan_.pairs() ? component : boundary_component);
  kernels::contact_start::Args start;
  start.threads = plan_.particles;
  start.base_x = base_[0];
  start.base_y = base_[1];
  start.base_z = base_[2];
  start.least_stiffness = least_stiffness_;
  start.owner = state.owner;
  start.origin = state.origin;
  start.position = state.position;
  start.linear_start = state.linear_start;
  start.start = buffer("contact_start");
  device_.run(start);
}

void Contacts::find(const ContactState& state) {
  if (!plan_.pairs()) return;
  device_.enter(component);
  each_kernel(state, [&](const auto& args) { device_.run(args); });
}

void Contacts::add_forces(const ContactState& state) {
  if (plan_.boundaries) {
    device_.enter(boundary_component);
    device_.run(boundary_args(*this, state, obstacles_.count(), base_, least_stiffness_));
  }
  if (plan_.pairs()) {
    device_.enter(component);
    device_.run(force_args(*this, state, friction_));
  }
}

void Contacts::add_product(const ContactState& state, BufferStorage* displacement, BufferStorage* direction) {
  if (!plan_.pairs()) return;
  device_.enter(component);
  device_.run(product_args(*this, state, friction_, displacement, direction));
}

ContactOverflow Contacts::overflow() {
  if (!plan_.pairs()) return {};
  const std::vector<std::uint32_t> values = device_.download_uint(buffer("left_out"));
  return {values[0], values[1]};
}

} // namespace pliant
