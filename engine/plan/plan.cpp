// From a scene to the components, kernels and buffers it needs.
#include "engine/plan/plan.h"

#include "engine/model/failure.h"
#include "engine/model/plasticity.h"
#include "engine/solver/contact.h"
#include "engine/solver/direct.h"
#include "engine/solver/elastic_law.h"
#include "engine/solver/fluid.h"
#include "engine/solver/frame.h"
#include "engine/solver/inversion.h"
#include "engine/solver/multilevel.h"
#include "engine/solver/saved_state.h"
#include "engine/solver/state.h"
#include "kernels/all.h"
#include "shaders/common/solver.glsl"

#include <algorithm>
#include <array>
#include <cstring>

namespace pliant {

namespace {

bool any_law(const Model& model, Law law) {
  return std::any_of(model.laws.begin(), model.laws.end(),
                     [law](const LawRange& range) { return range.law == law && range.count > 0; });
}

/// Adds what each component needs; each function is one component.
class Planner {
public:
  Planner(Plan& plan, const Scene& scene, const Model& model, const SlicedBonds& bonds)
      : plan_(plan), scene_(scene), model_(model), bonds_(bonds), n_(model.count()) {}

  void motion() {
    begin("motion", true);
    buffer("position", Type::real4, n_);
    buffer("velocity", Type::real4, n_);
    buffer("inertia_target", Type::real4, n_);
    buffer("displacement", Type::real4, n_);
    buffer("origin", Type::real4, model_.bodies.size());
    buffer("origin_shift", Type::real4, model_.bodies.size());
    buffer("anchor", Type::uint, model_.bodies.size());
    buffer("owner", Type::uint, n_);
    const std::uint32_t loaded = plan_.loaded, history = plan_.bdf2;
    kernel(kernels::predict::Args{.loaded = loaded}); // also the first step of BDF2
    kernel(kernels::advance::Args{.history = history});
    kernels<kernels::rebase_origin::Args, kernels::rebase_position::Args>();
    begin("bdf2", plan_.bdf2);
    kernel(kernels::predict::Args{.bdf2 = 1, .loaded = loaded});
    kernel(kernels::advance::Args{.bdf2 = 1, .history = 1});
    buffer("earlier_velocity", Type::real4, n_);
    buffer("earlier_shift", Type::real4, n_);
    begin("held particles", plan_.held);
    buffer("motion", Type::real4, 192);
    buffer("held", Type::uint, 2 * model_.held.size());
    buffer("held_start", Type::real4, model_.held.size());
    kernels<kernels::prescribe::Args>();
    begin("loads", plan_.loaded);
    buffer("external_force", Type::real4, n_);
  }

  /// Instead of everything else that moves particles.
  void fluid() {
    begin("motion", true);
    buffer("position", Type::real4, n_);
    buffer("velocity", Type::real4, n_);
    buffer("origin", Type::real4, model_.bodies.size());
    const FluidPlan needs = plan_fluid(scene_, model_, plan_.statistics);
    plan_.fluid_forces = needs.forces.viscous || needs.forces.spread;
    plan_.fluid_bonds = needs.bonds.any;
    plan_.fluid_flow = needs.bonds.flows();
    plan_.fluid_sources = needs.flow.used();
    const std::pair<const char*, bool> components[] = {{"neighbours", true},
                                                       {"density", true},
                                                       {"boundaries", needs.walls},
                                                       {"ghosts", needs.forces.ghosts},
                                                       {"viscosity", needs.forces.viscous},
                                                       {"redistribution", needs.forces.spread},
                                                       {"bonds", needs.bonds.any},
                                                       {"elasticity", needs.bonds.any},
                                                       {"plasticity", needs.bonds.flows()},
                                                       {"emitters", needs.flow.emitters > 0},
                                                       {"sinks", needs.flow.sinks > 0}};
    for (const auto& [component, used] : components) {
      begin(component, used);
      for (const BufferSpec& spec : needs.buffers)
        if (spec.component == component) buffer(spec.name, spec.type, spec.count);
      for (const KernelSpec& spec : needs.kernels)
        if (spec.component == component) kernel(spec);
      for (const BufferSpec& spec : needs.flow.counts) // the state's: they are saved and kept
        if (spec.component == component) buffer(spec.name, spec.type, spec.count);
    }
    component_ = "elasticity";
    active_ = needs.bonds.any;
    buffer("solver", Type::real, SOLVER_ENTRIES);
  }

  void leave_fluid() {
    for (const char* component :
         {"neighbours", "density", "ghosts", "viscosity", "redistribution", "emitters", "sinks"})
      begin(component, false);
  }

  void solver() {
    begin("solver", true);
    buffer("best_iterate", Type::real4, n_);
    buffer("force", Type::real4, n_);
    buffer("linear_start", Type::real4, n_);
    buffer("solver", Type::real, SOLVER_ENTRIES);
    const std::string& method = plan_.method.name;
    begin("stationary iteration", !plan_.method.line_search);
    const std::uint32_t position = method == "position";
    const std::size_t group = kernels::chebyshev_step::group_size, groups = (n_ + group - 1) / group;
    buffer("earlier_iterate", Type::real4, n_);
    buffer("residual_partial", Type::real4, groups);
    const std::uint32_t contacts = plan_.boundaries || plan_.pairs;
    for (const std::uint32_t checked : {0u, 1u})
      kernel(kernels::chebyshev_step::Args{.checked = checked, .position = position, .contacts = contacts});
    kernels<kernels::residual_control::Args, kernels::guard_apply::Args>();
    begin("line search", plan_.method.line_search);
    const std::uint32_t potential = plan_.method.potential;
    buffer("residual", Type::real4, n_);
    buffer("solve_partial", Type::real4, 2 * groups);
    buffer("preconditioned", Type::real4, n_);
    kernel(kernels::residual::Args{.potential = potential});
    kernel(kernels::line_control::Args{.potential = potential});
    kernels<kernels::line_apply::Args>();
    if (plan_.pairs) kernels<kernels::line_restart::Args>();
    begin("diagonal preconditioner", plan_.method.preconditioner == "diagonal");
    kernels<kernels::precondition::Args>();
    begin("preconditioner", plan_.method.preconditioner == "multilevel");
    if (active_) {
      plan_.hierarchy = std::make_shared<const Hierarchy>(build_hierarchy(scene_, model_));
      const MultilevelPlan needs =
          plan_multilevel(*plan_.hierarchy, model_, plan_contacts(scene_, model_, contact_use(plan_.method)));
      for (const BufferSpec& spec : needs.buffers) buffer(spec.name, spec.type, spec.count);
      for (const KernelSpec& spec : needs.kernels) kernel(spec);
    }
    begin("turning bonds", plan_.method.preconditioner == "multilevel" && turns_bonds(model_));
    buffer("rotation", Type::real4, n_);
    kernels<kernels::bond_rotation::Args>();
    begin("direct", plan_.method.preconditioner == "direct");
    if (active_) {
      plan_.direct = std::make_shared<const DirectPlan>(plan_direct(model_));
      for (const BufferSpec& spec : plan_.direct->buffers) buffer(spec.name, spec.type, spec.count);
      for (const KernelSpec& spec : plan_.direct->kernels) kernel(spec);
    }
    begin("newton", method == "newton");
    buffer("direction", Type::real4, n_);
    buffer("descent", Type::real4, n_);
    buffer("tangent", Type::real4, 4 * n_);
    kernel(kernels::conjugate_control::Args{.after = 0});
    kernel(kernels::conjugate_control::Args{.after = 1});
    kernels<kernels::conjugate_direction::Args, kernels::conjugate_update::Args>();
    kernel(kernels::newton_product::Args{.obstacles = plan_.boundaries});
    begin("quasi-newton", plan_.method.line_search && method != "newton");
    const std::uint32_t remembers = method == "lbfgs";
    kernel(kernels::history_control::Args{.remembers = remembers});
    kernel(kernels::history_direction::Args{.remembers = remembers});
    begin("l-bfgs", remembers != 0);
    buffer("history", Type::real4, std::size_t{HISTORY_ROWS} * n_);
    buffer("history_partial", Type::real, std::size_t{HISTORY_DOTS} * groups);
    buffer("gram", Type::real, std::size_t{2} * MEMORY * MEMORY);
    kernels<kernels::history_store::Args, kernels::history_dots::Args>();
  }

  void elasticity() {
    const std::size_t rows = bonds_.slice_begin.empty() ? 0 : bonds_.slice_begin.back() / slice_width;
    begin("bonds", !laws().empty());
    buffer("slice_begin", Type::uint, bonds_.slice_begin.size());
    buffer("bond", Type::uint, 2 * slice_width * rows);
    buffer("weight", Type::real, 2 * slice_width * rows);
    std::uint32_t shape_rows = 0;
    for (const Law law : laws())
      shape_rows = std::max(shape_rows, static_cast<std::uint32_t>(needs(law).shape_rows));
    if (plan_.failure) plan_.share_row = shape_rows; // and the next
    buffer("shape", Type::real, n_ * (shape_rows + (plan_.failure ? 2 : 0)));
    for (const Law law : elastic_laws()) {
      begin(std::string(law_name(law)) + " elasticity", any_law(model_, law));
      if (!active_) continue;
      const LawNeeds wanted = needs(law);
      for (const BufferSpec& spec : wanted.buffers) buffer(spec.name, spec.type, spec.count);
      for (const KernelSpec& spec : wanted.kernels) kernel({spec.info, component_, spec.options});
    }
    begin("inversion", resists_inversion(scene_, model_));
    if (!active_) return;
    const InversionNeeds wanted = inversion();
    for (const BufferSpec& spec : wanted.buffers) buffer(spec.name, spec.type, spec.count);
    for (const KernelSpec& spec : wanted.kernels) kernel({spec.info, component_, spec.options});
  }

  /// Flat neighbourhoods choose variants of kernels; they need nothing else.
  void flatness() {
    begin("sheets", plan_.sheets);
    begin("plane", plan_.plane);
  }

  void contacts() {
    const ContactPlan needs = plan_contacts(scene_, model_, contact_use(plan_.method));
    plan_.boundaries = needs.boundaries;
    plan_.pairs = needs.pairs();
    for (const auto& [component, used] :
         {std::pair{"boundaries", plan_.boundaries}, {"contacts", plan_.pairs}}) {
      begin(component, used);
      for (const BufferSpec& spec : needs.buffers)
        if (spec.component == component) buffer(spec.name, spec.type, spec.count);
      for (const KernelSpec& spec : needs.kernels)
        if (spec.component == component) kernel(spec);
    }
  }

  void sums(const Chunks& chunks) {
    begin("momentum", plan_.momentum);
    buffer("chunk", Type::uint4, chunks.chunk.size());
    buffer("component", Type::uint4, chunks.component.size());
    buffer("moment", Type::real4, 5 * chunks.chunk.size());
    buffer("rigid", Type::real4, 3 * chunks.component.size());
    kernel(kernels::component_moments::Args{.contacts = plan_.boundaries || plan_.pairs});
    kernels<kernels::component_motion::Args, kernels::component_apply::Args>();
    begin("energy", plan_.energy);
    buffer("energy", Type::real, n_);
    for (const std::size_t gated : {0u, 1u}) // at the end of a step, and where a line search looks at it
      for (const Law law : laws()) {
        const LawNeeds wanted = needs(law);
        if (gated < wanted.energies.size())
          kernel({wanted.energies[gated].info, component_, wanted.energies[gated].options});
      }
    if (resists_inversion(scene_, model_))
      for (const KernelSpec& spec : inversion().energies) kernel({spec.info, component_, spec.options});
    begin("failure", plan_.failure);
    buffer("toughness", Type::real4, n_);
    kernels<kernels::bond_break::Args>();
    if (plan_.energy) {
      buffer("energy_before", Type::real, n_);
      buffer("released", Type::real, n_);
      buffer("fracture", Type::real, std::size_t{2} * statistics_rows);
      kernels<kernels::bond_release::Args, kernels::fracture_sum::Args>();
    }
    if (!plan_.fluid) begin("plasticity", plan_.plastic);
    active_ = plan_.plastic;
    buffer("rest", Type::real, bonds_.slice_begin.empty() ? 0 : std::size_t{2} * bonds_.slice_begin.back());
    buffer("yield", Type::real4, 2 * n_);
    buffer("flow", Type::real4, 2 * n_);
    buffer("plastic_row", Type::real, std::size_t{5} * statistics_rows);
    kernels<kernels::plastic_return::Args, kernels::plastic_flow::Args, kernels::plastic_sum::Args>();
    begin("statistics", plan_.statistics);
    buffer("chunk", Type::uint4, chunks.chunk.size());
    buffer("chunk_sum", Type::real4, 2 * chunks.chunk.size());
    buffer("statistics", Type::real, std::size_t{16} * statistics_rows);
    if (plan_.fluid) buffer("solver", Type::real, SOLVER_ENTRIES);
    kernel(kernels::statistics_chunk::Args{.energies = plan_.energy});
    kernels<kernels::statistics_total::Args>();
    begin("divergence", plan_.divergence);
    buffer("chunk", Type::uint4, chunks.chunk.size());
    buffer("chunk_sum", Type::real4, 2 * chunks.chunk.size());
    buffer("statistics", Type::real, std::size_t{16} * statistics_rows);
    if (plan_.fluid) buffer("solver", Type::real, SOLVER_ENTRIES);
    kernel(kernels::statistics_chunk::Args{.energies = plan_.statistics && plan_.energy});
    kernels<kernels::statistics_total::Args>();
    for (const std::string& name : persistent_buffers(plan_))
      if (const BufferSpec* spec = plan_.find(name)) {
        const BufferSpec like = *spec; // buffer() may move what it points to
        buffer(kept_name(name), like.type, like.count);
      }
  }

  void frames(const PlanRequest& request) {
    const FrameNeeds needs = frame_needs(scene_, model_, request);
    plan_.frames = request.frames;
    plan_.surfaces = needs.surfaces;
    plan_.strain = needs.strain;
    for (const char* component : {"frames", "surfaces", "strain"}) {
      const std::string name = component;
      begin(component, name == "frames" ? plan_.frames : name == "surfaces" ? plan_.surfaces : plan_.strain);
      if (plan_.fluid && name == "frames") buffer("owner", Type::uint, n_);
      for (const BufferSpec& spec : needs.buffers)
        if (spec.component == name) buffer(spec.name, spec.type, spec.count);
      for (const KernelSpec& spec : needs.kernels)
        if (spec.component == name) kernel(spec);
    }
  }

private:
  std::vector<Law> laws() const {
    std::vector<Law> found;
    for (const Law law : elastic_laws())
      if (any_law(model_, law)) found.push_back(law);
    return found;
  }
  InversionNeeds inversion() const {
    return inversion_needs(model_, plan_.method.name == "newton", plan_.method.potential);
  }
  LawNeeds needs(Law law) const {
    return law_needs(law, {.scene = scene_,
                           .model = model_,
                           .bonds = bonds_,
                           .derivative = plan_.method.name == "newton",
                           .potential = plan_.method.potential,
                           .failing = plan_.failure});
  }
  void begin(const std::string& component, bool used) {
    component_ = component;
    active_ = used;
    (used ? plan_.used : plan_.left_out).push_back(component);
  }
  void buffer(const std::string& name, Type type, std::size_t count) {
    if (!active_ || plan_.find(name)) return;
    plan_.buffers.push_back({name, type, count, component_});
  }
  void kernel(const KernelSpec& wanted) {
    if (!active_) return;
    const auto same = [&](const KernelSpec& spec) {
      return spec.info == wanted.info && spec.options == wanted.options;
    };
    if (std::none_of(plan_.kernels.begin(), plan_.kernels.end(), same)) plan_.kernels.push_back(wanted);
  }
  template <class Args> void kernel(const Args& args) { kernel(kernel_variant(args, component_)); }
  template <class... Args> void kernels() { (kernel(Args{}), ...); }

  Plan& plan_;
  const Scene& scene_;
  const Model& model_;
  const SlicedBonds& bonds_;
  std::size_t n_;
  std::string component_;
  bool active_ = false;
};

constexpr std::array bond_buffers{"slice_begin", "bond", "weight", "rest"};

bool of_bonds(const std::string& name) {
  return std::find(bond_buffers.begin(), bond_buffers.end(), name) != bond_buffers.end();
}

} // namespace

const BufferSpec* Plan::find(const std::string& name) const {
  for (const BufferSpec& spec : buffers)
    if (spec.name == name) return &spec;
  return nullptr;
}

std::size_t Plan::bytes(Precision precision) const {
  std::size_t sum = 0;
  for (const BufferSpec& spec : buffers) sum += spec.count * element_bytes(spec.type, precision);
  return sum;
}

double Plan::bytes_per_bond(Precision precision) const {
  double sum = 0;
  for (const BufferSpec& spec : buffers)
    if (of_bonds(spec.name)) sum += static_cast<double>(spec.count * element_bytes(spec.type, precision));
  return bonds ? sum / static_cast<double>(bonds) : 0;
}

double Plan::bytes_per_particle(Precision precision) const {
  double sum = 0;
  for (const BufferSpec& spec : buffers)
    if (!of_bonds(spec.name)) sum += static_cast<double>(spec.count * element_bytes(spec.type, precision));
  return particles ? sum / static_cast<double>(particles) : 0;
}

Plan make_plan(const Scene& scene, const Model& model, const SlicedBonds& bonds, const PlanRequest& request) {
  Plan plan;
  plan.particles = model.count();
  plan.bonds = model.bonds.count();
  plan.sheets = model.has_sheets();
  plan.plane = model.dimension == 2;
  plan.bdf2 = scene.solver.integrator == "bdf2";
  plan.held = !model.held.empty();
  plan.loaded = !model.loads.empty();
  plan.momentum = scene.solver.restore_momentum && model.count() > 0;
  plan.statistics = request.statistics;
  plan.divergence = request.divergence;
  const bool drawn = scene.render.color == "energy" || std::find(request.fields.begin(), request.fields.end(),
                                                                 "energy") != request.fields.end();
  plan.failure = can_break(scene, model);
  plan.fluid = any_law(model, Law::fluid);
  plan.plastic = !plan.fluid && can_flow(scene, model);
  if (plan.fluid) plan.momentum = false;
  if (!plan.fluid) plan.method = choose_method(scene, model);
  plan.energy = !plan.fluid && (request.statistics || plan.method.potential || (request.frames && drawn));
  Planner planner(plan, scene, model, bonds);
  if (plan.fluid) {
    planner.fluid();
  } else {
    planner.motion();
    planner.contacts();
    planner.solver();
    planner.elasticity();
    planner.leave_fluid();
  }
  planner.flatness();
  planner.sums(make_chunks(model));
  planner.frames(request);
  return plan;
}

void prepare_kernels(Device& device, const Plan& plan) {
  for (const KernelSpec& spec : plan.kernels) {
    // A device compiles from the options alone: the rest of Args stays zero. Held in doubles for their
    // alignment.
    std::vector<double> args(2);
    for (const Field& field : spec.info->fields)
      args.resize(std::max(args.size(), field.offset / sizeof(double) + 2));
    auto option = spec.options.begin();
    for (const Field& field : spec.info->fields)
      if (field.role == Role::option && option != spec.options.end())
        std::memcpy(reinterpret_cast<char*>(args.data()) + field.offset, &*option++, sizeof *option);
    device.prepare(*spec.info, args.data());
  }
}

Chunks make_chunks(const Model& model) {
  Chunks chunks;
  const auto n = static_cast<std::uint32_t>(model.count());
  const auto conserves_spin = [&](std::uint32_t particle) {
    for (const LawRange& range : model.laws)
      if (particle >= range.first && particle < range.first + range.count)
        return range.law != Law::projective;
    return true;
  };
  for (std::uint32_t first = 0; first < n;) {
    const std::uint32_t component = model.component[first];
    std::uint32_t end = first;
    while (end < n && model.component[end] == component) ++end;
    const auto first_chunk = static_cast<std::uint32_t>(chunks.chunk.size());
    const auto index = static_cast<std::uint32_t>(chunks.component.size());
    for (std::uint32_t begin = first; begin < end; begin += chunk_size)
      chunks.chunk.push_back({begin, std::min(end, begin + chunk_size), index, 0});
    chunks.component.push_back(
        {first_chunk, static_cast<std::uint32_t>(chunks.chunk.size()), conserves_spin(first) ? 1u : 0u, 0});
    first = end;
  }
  return chunks;
}

} // namespace pliant
