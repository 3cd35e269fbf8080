// Runs the multilevel preconditioner's kernels.
#include "engine/solver/multilevel.h"

#include "engine/solver/contact.h"
#include "engine/solver/elasticity.h"
#include "engine/solver/state.h"
#include "kernels/bond_rotation.h"
#include "kernels/coarse_contact.h"
#include "kernels/coarse_factor.h"
#include "kernels/coarse_interpolate.h"
#include "kernels/coarse_matrix.h"
#include "kernels/coarse_restrict.h"
#include "kernels/coarse_rotation.h"
#include "kernels/coarse_solve.h"
#include "kernels/coarse_sweep.h"
#include "kernels/precondition.h"

#include <algorithm>

namespace pliant {

namespace {

constexpr const char* component = "preconditioner";
/// Of block Jacobi. The cycle is positive definite below 2 over the largest eigenvalue of the inverse blocks
/// times the matrix, which is 2.6 at a Poisson's ratio of .3 and a little over 5 at .499.
constexpr double relaxation = 0.38;

bool has_rotation(const LawRange& range) {
  return range.count > 0 && (range.law == Law::corotated || range.law == Law::neo_hookean);
}

bool rotates(const Model& model) {
  return turns_bonds(model) || std::any_of(model.laws.begin(), model.laws.end(), has_rotation);
}

} // namespace

bool turns_bonds(const LawRange& range) {
  return range.count > 0 && range.law == Law::basis;
}

bool turns_bonds(const Model& model) {
  return std::any_of(model.laws.begin(), model.laws.end(),
                     [](const LawRange& range) { return turns_bonds(range); });
}

MultilevelPlan plan_multilevel(const Hierarchy& h, const Model& model, const ContactPlan& contacts) {
  MultilevelPlan plan;
  const std::uint32_t rotated = rotates(model), obstacles = contacts.boundaries && contacts.use.tangent;
  const auto buffer = [&](const char* name, Type type, std::size_t count) {
    plan.buffers.push_back({name, type, count, component});
  };
  const auto kernel = [&](const auto& args) { plan.kernels.push_back(kernel_variant(args, component)); };
  const std::size_t slices = h.nodes / slice_width;
  buffer("coarse_neighbour", Type::uint, h.neighbour.size());
  buffer("coarse_cell", Type::uint, h.cell.size());
  buffer("coarse_signature", Type::uint, h.signature.size());
  buffer("coarse_stiffness", Type::real, h.stiffness.size());
  buffer("coarse_gather_begin", Type::uint, h.gather_begin.size());
  buffer("coarse_gather", Type::uint, h.gather.size());
  buffer("coarse_gather_weight", Type::real, h.gather.size());
  buffer("particle_node", Type::uint, h.particle_node.size());
  buffer("particle_weight", Type::real, h.particle_node.size());
  buffer("node_parent", Type::uint, h.node_parent.size());
  buffer("parent_weight", Type::real, h.node_parent.size());
  buffer("coarse_matrix", Type::real, slices * 27 * 144);
  buffer("coarse_inverse", Type::real, slices * 144);
  buffer("coarse_factor", Type::real, std::size_t{576} * h.blocks);
  buffer("coarse_load", Type::real4, h.nodes);
  buffer("coarse_iterate", Type::real4, h.nodes);
  buffer("coarse_result", Type::real4, h.nodes);
  if (rotated) {
    buffer("coarse_child_begin", Type::uint, h.child_begin.size());
    buffer("coarse_child", Type::uint, h.child.size());
    buffer("cell_rotation", Type::real4, h.cells);
    kernel(kernels::coarse_rotation::Args{.particles = 1});
    if (h.levels.size() > 1) kernel(kernels::coarse_rotation::Args{.particles = 0});
  }
  if (obstacles) {
    buffer("coarse_block", Type::real4, std::size_t{2} * h.nodes);
    kernel(kernels::coarse_contact::Args{.particles = 1});
    if (h.levels.size() > 1) kernel(kernels::coarse_contact::Args{.particles = 0});
  }
  kernel(kernels::coarse_matrix::Args{.rotated = rotated, .obstacles = obstacles});
  kernel(kernels::coarse_factor::Args{});
  kernel(kernels::coarse_restrict::Args{});
  if (h.levels.size() > 1) {
    kernel(kernels::coarse_sweep::Args{.relaxed = 0});
    kernel(kernels::coarse_sweep::Args{.relaxed = 1});
    kernel(kernels::coarse_interpolate::Args{});
  }
  kernel(kernels::coarse_solve::Args{});
  kernel(kernels::precondition::Args{.multilevel = 1});
  return plan;
}

Multilevel::Multilevel(const SolveContext& context)
    : Preconditioner(context), hierarchy_(*context.plan.hierarchy), rotated_(rotates(context.model)),
      obstacles_(context.plan.boundaries && context.plan.find("coarse_block")) {
  Device& device = context_.device;
  for (const BufferSpec& spec : context.plan.buffers)
    if (spec.component == component)
      buffers_.emplace(spec.name, device.allocate(spec.name, spec.type, spec.count));
  const Hierarchy& h = hierarchy_;
  const auto upload = [&](const char* name, const auto& values) { device.upload(at(name), values); };
  upload("coarse_neighbour", h.neighbour);
  upload("coarse_cell", h.cell);
  upload("coarse_signature", h.signature);
  upload("coarse_stiffness", h.stiffness);
  upload("coarse_gather_begin", h.gather_begin);
  upload("coarse_gather", h.gather);
  upload("coarse_gather_weight", h.gather_weight);
  upload("particle_node", h.particle_node);
  upload("particle_weight", h.particle_weight);
  upload("node_parent", h.node_parent);
  upload("parent_weight", h.parent_weight);
  if (!rotated_) return;
  upload("coarse_child_begin", h.child_begin);
  upload("coarse_child", h.child);
}

BufferStorage* Multilevel::at(const std::string& name) const {
  const auto found = buffers_.find(name);
  return found == buffers_.end() ? nullptr : static_cast<BufferStorage*>(found->second);
}

void Multilevel::refresh() {
  Device& device = context_.device;
  const SimulationState& s = context_.state;
  device.enter(component);
  for (const LawRange& range : context_.model.laws)
    if (turns_bonds(range))
      device.run(kernels::bond_rotation::Args{.threads = range.count,
                                              .first = range.first,
                                              .first_slice = range.first_slice,
                                              .unit = context_.elasticity.unit(),
                                              .slice_begin = s.slice_begin,
                                              .bond = s.bond,
                                              .weight = s.weight,
                                              .position = s.position,
                                              .displacement = s.best_iterate,
                                              .shape = s.shape,
                                              .rotation = s.rotation,
                                              .solver = s.solver});
  for (std::size_t l = 0; l < hierarchy_.levels.size(); ++l) {
    const HierarchyLevel& level = hierarchy_.levels[l];
    if (rotated_)
      device.run(kernels::coarse_rotation::Args{.threads = level.cells,
                                                .particles = l == 0,
                                                .first_cell = level.first_cell,
                                                .child_begin = at("coarse_child_begin"),
                                                .child = at("coarse_child"),
                                                .rotation = s.rotation,
                                                .solver = s.solver,
                                                .cell_rotation = at("cell_rotation")});
    if (obstacles_)
      device.run(kernels::coarse_contact::Args{.threads = level.nodes,
                                               .particles = l == 0,
                                               .first_node = level.first_node,
                                               .first_slice = level.first_gather,
                                               .gather_begin = at("coarse_gather_begin"),
                                               .gather = at("coarse_gather"),
                                               .gather_weight = at("coarse_gather_weight"),
                                               .contact_block = context_.contacts->block(),
                                               .solver = s.solver,
                                               .coarse_block = at("coarse_block")});
    device.run(kernels::coarse_matrix::Args{.threads = level.nodes,
                                            .rotated = rotated_,
                                            .obstacles = obstacles_,
                                            .first_node = level.first_node,
                                            .per_step2 = 1 / (bounds_.step * bounds_.step),
                                            .cell = at("coarse_cell"),
                                            .signature = at("coarse_signature"),
                                            .stiffness = at("coarse_stiffness"),
                                            .cell_rotation = at("cell_rotation"),
                                            .coarse_block = at("coarse_block"),
                                            .solver = s.solver,
                                            .matrix = at("coarse_matrix"),
                                            .inverse_block = at("coarse_inverse")});
  }
  device.run(kernels::coarse_factor::Args{.threads = hierarchy_.blocks * kernels::coarse_factor::group_size,
                                          .first_node = hierarchy_.levels.back().first_node,
                                          .neighbour = at("coarse_neighbour"),
                                          .matrix = at("coarse_matrix"),
                                          .solver = s.solver,
                                          .factor = at("coarse_factor")});
}

void Multilevel::restrict_to(std::size_t l, BufferStorage* source) {
  const HierarchyLevel& level = hierarchy_.levels[l];
  context_.device.run(kernels::coarse_restrict::Args{.threads = level.nodes,
                                                     .first_node = level.first_node,
                                                     .first_slice = level.first_gather,
                                                     .relaxation = relaxation,
                                                     .gather_begin = at("coarse_gather_begin"),
                                                     .gather = at("coarse_gather"),
                                                     .gather_weight = at("coarse_gather_weight"),
                                                     .source = source,
                                                     .inverse_block = at("coarse_inverse"),
                                                     .solver = context_.state.solver,
                                                     .coarse_load = at("coarse_load"),
                                                     .coarse_iterate = at("coarse_iterate")});
}

void Multilevel::sweep(const HierarchyLevel& level, bool relaxed) {
  context_.device.run(kernels::coarse_sweep::Args{.threads = level.nodes,
                                                  .relaxed = relaxed,
                                                  .first_node = level.first_node,
                                                  .relaxation = relaxation,
                                                  .neighbour = at("coarse_neighbour"),
                                                  .matrix = at("coarse_matrix"),
                                                  .inverse_block = at("coarse_inverse"),
                                                  .coarse_load = at("coarse_load"),
                                                  .coarse_iterate = at("coarse_iterate"),
                                                  .solver = context_.state.solver,
                                                  .coarse_result = at("coarse_result")});
}

void Multilevel::apply() {
  Device& device = context_.device;
  const SimulationState& s = context_.state;
  const std::vector<HierarchyLevel>& levels = hierarchy_.levels;
  device.enter(component);
  restrict_to(0, s.residual);
  for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
    sweep(levels[l], false);
    restrict_to(l + 1, at("coarse_result"));
  }
  device.run(kernels::coarse_solve::Args{.threads = hierarchy_.blocks * kernels::coarse_solve::group_size,
                                         .first_node = levels.back().first_node,
                                         .factor = at("coarse_factor"),
                                         .coarse_load = at("coarse_load"),
                                         .solver = s.solver,
                                         .coarse_result = at("coarse_result")});
  for (std::size_t l = levels.size() - 1; l-- > 0;) {
    device.run(kernels::coarse_interpolate::Args{.threads = levels[l].nodes,
                                                 .first_node = levels[l].first_node,
                                                 .node_parent = at("node_parent"),
                                                 .parent_weight = at("parent_weight"),
                                                 .coarse_result = at("coarse_result"),
                                                 .solver = s.solver,
                                                 .coarse_iterate = at("coarse_iterate")});
    sweep(levels[l], true);
  }
  device.run(kernels::precondition::Args{.threads = static_cast<std::uint32_t>(context_.plan.particles),
                                         .multilevel = 1,
                                         .residual = s.residual,
                                         .solver = s.solver,
                                         .preconditioned = s.preconditioned,
                                         .solve_partial = s.solve_partial,
                                         .particle_node = at("particle_node"),
                                         .particle_weight = at("particle_weight"),
                                         .coarse_result = at("coarse_result")});
}

} // namespace pliant
