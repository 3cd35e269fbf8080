// Setting a simulation up, and reading its state back.
#include "engine/solver/simulation.h"

#include "engine/core/error.h"
#include "engine/solver/contact.h"
#include "engine/solver/elasticity.h"
#include "engine/solver/failure.h"
#include "engine/solver/fluid.h"
#include "engine/solver/frame.h"
#include "engine/solver/global_step.h"
#include "engine/solver/motion.h"
#include "engine/solver/plasticity.h"
#include "engine/solver/saved_state.h"
#include "engine/solver/state.h"
#include "engine/solver/stiffness.h"
#include "kernels/all.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace pliant {

namespace {

using Real4d = Real4<double>;

Real4d pack(const Vector3& v, double w = 0) {
  return {v.x(), v.y(), v.z(), w};
}
Vector3 unpack(const Real4d& v) {
  return {v.x, v.y, v.z};
}

/// A body's positions stay within a few quanta of its origin; origins move by whole quanta.
double origin_quantum(const Model& model, const BodyModel& body) {
  double extent = model.spacing;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
    extent = std::max(extent, model.reference[i].cwiseAbs().maxCoeff());
  return std::exp2(std::ceil(std::log2(extent)));
}

/// The particle nearest to the middle of a body's reference.
std::uint32_t anchor_of(const Model& model, const BodyModel& body) {
  Vector3 middle = Vector3::Zero();
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) middle += model.reference[i];
  if (body.count > 0) middle /= body.count;
  std::uint32_t best = body.first;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
    if ((model.reference[i] - middle).squaredNorm() < (model.reference[best] - middle).squaredNorm())
      best = i;
  return best;
}

} // namespace

Simulation::Simulation(Device& device, const Scene& scene, const Model& model, const PlanRequest& request)
    : device_(device), scene_(scene), model_(model), state_(std::make_unique<SimulationState>()) {
  if (model.count() == 0) throw Error(ExitCode::usage, "the scene has no particles: give it a [[body]]");
  const SlicedBonds bonds = slice_bonds(model);
  plan_ = make_plan(scene, model, bonds, request);
  if (!plan_.fluid)
    elasticity_ = std::make_unique<Elasticity>(device, scene, model, *state_, plan_.share_row);
  chunks_ = make_chunks(model);
  time_step_ = whole_step(scene);
  for (const BodyModel& body : model.bodies)
    scene_origin_ += body.origin / static_cast<double>(model.bodies.size());
  // Snapped, so that moving a scene by a round distance moves no bit of it.
  const double grain = std::exp2(std::ceil(std::log2(model.spacing)) + 6);
  scene_origin_ = (scene_origin_ / grain).array().round() * grain;
  allocate();
  upload(bonds);
  if (!plan_.fluid && (plan_.boundaries || plan_.pairs))
    contacts_ = std::make_unique<Contacts>(device_, scene, model, scene_origin_, contact_use(plan_.method));
  if (plan_.failure)
    failure_ = std::make_unique<Failure>(device_, scene, model, plan_, *state_, *elasticity_);
  if (plan_.plastic)
    plastic_ = std::make_unique<PlasticFlow>(device_, scene, model, plan_, *state_, elasticity_->unit());
  if (plan_.fluid)
    fluid_ = std::make_unique<Fluid>(device_, scene, model, plan_, *state_, scene_origin_);
  else
    global_step_ = make_global_step({device_, scene_, model_, plan_, *state_, *elasticity_, contacts_.get()});
  choose_step(time_step_);
  if (plan_.frames) frame_ = std::make_unique<FrameOutput>(*this);
  prepare_kernels(device_, plan_);
}

Simulation::~Simulation() = default;

void Simulation::allocate() {
  for (const BufferSpec& spec : plan_.buffers)
    if (Buffer* buffer = state_->find(spec.name))
      *buffer = device_.allocate(spec.name, spec.type, spec.count);
  for (const std::string& name : persistent_buffers(plan_))
    if (const BufferSpec* spec = plan_.find(kept_name(name)))
      state_->kept[name] = device_.allocate(spec->name, spec->type, spec->count);
}

void Simulation::upload(const SlicedBonds& bonds) {
  SimulationState& s = *state_;
  const std::size_t n = model_.count();
  std::vector<Real4d> rows(n);
  std::vector<Real4d> origins;
  std::vector<std::uint32_t> anchors;
  for (const BodyModel& body : model_.bodies) {
    origins.push_back(pack(body.origin - scene_origin_, origin_quantum(model_, body)));
    anchors.push_back(anchor_of(model_, body));
  }
  device_.upload(s.origin, origins);
  if (s.anchor) device_.upload(s.anchor, anchors);
  if (s.owner) device_.upload(s.owner, model_.body);
  for (std::size_t i = 0; i < n; ++i)
    rows[i] = pack(model_.position[i] - model_.bodies[model_.body[i]].origin,
                   model_.bodies[model_.body[i]].emitted ? 0 : model_.mass[i]);
  device_.upload(s.position, rows);
  for (std::size_t i = 0; i < n; ++i)
    rows[i] = pack(model_.velocity[i], 1); // as if falling: nothing held it yet
  device_.upload(s.velocity, rows);
  if (s.chunk) device_.write(s.chunk, 0, std::as_bytes(std::span(chunks_.chunk)));
  if (plan_.fluid) {                    // fluids upload what is theirs
    for (std::size_t i = 0; i < n; ++i) // no multipliers to start with
      rows[i] = model_.bodies[model_.body[i]].emitted ? Real4d{} : pack(model_.velocity[i]);
    device_.upload(s.velocity, rows);
    return;
  }
  const std::vector<double> stiffness = diagonal_stiffness(model_);
  for (std::size_t i = 0; i < n; ++i) rows[i] = {0, 0, 0, stiffness[i]};
  device_.upload(s.linear_start, rows);
  if (plan_.find("rotation")) {
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Quaterniond q(model_.bodies[model_.body[i]].axes);
      rows[i] = {q.x(), q.y(), q.z(), q.w()};
    }
    device_.upload(s.rotation, rows);
  }
  // Bonds: rows of 16 neighbours, 16 packed vectors; 16 outgoing, 16 incoming weights.
  const std::size_t entries = bonds.neighbour.size();
  std::vector<std::uint32_t> begins(bonds.slice_begin), packed(2 * entries);
  std::vector<double> weights(2 * entries);
  for (std::uint32_t& begin : begins) begin /= slice_width;
  for (std::size_t e = 0; e < entries; ++e) {
    const std::size_t at = e / slice_width * 2 * slice_width + e % slice_width;
    packed[at] = bonds.neighbour[e];
    packed[at + slice_width] = bonds.offset[e];
    weights[at] = bonds.weight_out[e];
    weights[at + slice_width] = bonds.weight_in[e];
  }
  device_.upload(s.slice_begin, begins);
  device_.upload(s.bond, packed);
  device_.upload(s.weight, weights);
  elasticity_->upload();
  if (plan_.momentum) device_.write(s.component, 0, std::as_bytes(std::span(chunks_.component)));
}

void Simulation::choose_step(double step) {
  const Stiffness stiffness = stiffness_of(model_, step);
  solve_step_ = step;
  stiffness_number_ = stiffness.number;
  const double epsilon = device_.info().precision == Precision::double_precision
                             ? std::numeric_limits<double>::epsilon()
                             : std::numeric_limits<float>::epsilon();
  // Forces are sums of terms of size K times the spacing, each wrong by one rounding: half an epsilon.
  rounding_ = epsilon / 2;
  floor_ = rounding_ * model_.spacing * stiffness.noise;
}

void Simulation::begin_step() {
  const double end = (static_cast<double>(step_) + (part_ + 1.0) / parts_) * time_step_;
  const double whole = time_step_ / parts_;
  const double wanted = plan_.bdf2 && !first_of_bdf2_ ? whole * 2 / 3 : whole;
  if (wanted != solve_step_) choose_step(wanted);
  if (contacts_) contacts_->begin_step(end - whole, whole, contact_state(*state_));
  if (plan_.held) gather_held(end);
  if (plan_.loaded) {
    std::vector<Real4d> force(model_.count(), Real4d{0, 0, 0, 0});
    for (const Load& load : model_.loads)
      if (load.start <= end && end <= load.end) {
        Real4d& f = force[load.particle];
        f = {f.x + load.force.x(), f.y + load.force.y(), f.z + load.force.z(), 0};
      }
    const bool same = force.size() == loaded_.size() &&
                      std::memcmp(force.data(), loaded_.data(), force.size() * sizeof(Real4d)) == 0;
    if (!same) device_.upload(state_->external_force, force);
    loaded_ = std::move(force);
  }
}

void Simulation::gather_held(double time) {
  SimulationState& s = *state_;
  std::vector<Real4d> rows;
  for (const Motion& motion : model_.motions) {
    const RigidMap map = motion_at(motion, time);
    const Vector3 shift =
        map(scene_origin_) - scene_origin_; // device coordinates are relative to the scene's origin
    for (int r = 0; r < 3; ++r) rows.push_back(pack(map.rotation.row(r), shift[r]));
  }
  device_.upload(s.motion, rows);
  std::vector<std::uint32_t> entries;
  std::vector<Real4d> starts;
  for (const Held& held : model_.held) {
    const Motion& motion = model_.motions[held.motion];
    if (released(motion, time)) continue;
    entries.insert(entries.end(), {held.particle, held.motion});
    starts.push_back(pack(model_.position[held.particle] - scene_origin_));
  }
  if (starts.size() == held_count_ && step_ > 0) return;
  held_count_ = static_cast<std::uint32_t>(starts.size());
  device_.upload(s.held, entries);
  device_.upload(s.held_start, starts);
}

std::vector<Vector3> Simulation::positions() {
  const std::vector<Real4d> y = device_.download_real4(state_->position),
                            o = device_.download_real4(state_->origin);
  std::vector<Vector3> world(y.size());
  for (std::size_t i = 0; i < y.size(); ++i)
    world[i] = scene_origin_ + unpack(o[model_.body[i]]) + unpack(y[i]);
  return world;
}

std::vector<double> Simulation::damage() {
  return failure_ ? failure_->damage() : std::vector<double>(model_.count(), 0.0);
}

std::vector<double> Simulation::plastic_strain() {
  if (plan_.fluid_flow) return fluid_->plastic_strain();
  return plastic_ ? plastic_->strain() : std::vector<double>(model_.count(), 0.0);
}

std::uint32_t Simulation::contacts_dropped() {
  return contacts_ && step_ > 0 ? contacts_->overflow().contacts : 0;
}

std::vector<Vector3> Simulation::velocities() {
  const std::vector<Real4d> v = device_.download_real4(state_->velocity);
  std::vector<Vector3> result(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) result[i] = unpack(v[i]);
  return result;
}

Snapshot Simulation::snapshot() {
  SimulationState& s = *state_;
  Snapshot state;
  state.step = step_;
  state.position = positions();
  for (const Real4d& v : device_.download_real4(s.velocity)) {
    state.velocity.push_back(unpack(v));
    state.felt_gravity.push_back(v.w);
  }
  if (plan_.bdf2) {
    for (const Real4d& v : device_.download_real4(s.earlier_velocity))
      state.earlier_velocity.push_back(unpack(v));
    for (const Real4d& v : device_.download_real4(s.earlier_shift)) state.earlier_shift.push_back(unpack(v));
  }
  if (plan_.find("rotation")) state.rotation = device_.download_real4(s.rotation);
  if (plan_.plastic) {
    state.rest = device_.download_real(s.rest);
    state.flow = device_.download_real4(s.flow);
    state.diagonal = device_.download_real4(s.linear_start);
  }
  if (plan_.fluid)
    for (const Real4d& y : device_.download_real4(s.position)) state.mass.push_back(y.w);
  if (plan_.fluid_bonds) {
    state.bonds.near_count = device_.download_uint(fluid_->buffer("near_count"));
    state.bonds.near = device_.download_uint(fluid_->buffer("near"));
    state.bonds.near_place_of = device_.download_uint(fluid_->buffer("near_place_of"));
    state.bonds.near_rest = device_.download_real(fluid_->buffer("near_rest"));
    if (plan_.fluid_flow) state.bonds.fluid_flow = device_.download_real4(fluid_->buffer("fluid_flow"));
  }
  if (s.emitter_count) state.emitter_count = device_.download_uint(s.emitter_count);
  if (s.sunk) state.sunk = device_.download_uint(s.sunk);
  return state;
}

void Simulation::restore(const Snapshot& state) {
  SimulationState& s = *state_;
  const std::size_t n = model_.count();
  if (state.position.size() != n || state.velocity.size() != n)
    throw Error(ExitCode::internal, "a state of " + std::to_string(state.position.size()) +
                                        " particles given to a scene of " + std::to_string(n));
  step_ = state.step;
  const std::vector<Real4d> o = device_.download_real4(s.origin);
  std::vector<Real4d> rows(n);
  for (std::size_t i = 0; i < n; ++i)
    rows[i] = pack(state.position[i] - scene_origin_ - unpack(o[model_.body[i]]),
                   state.mass.empty() ? model_.mass[i] : state.mass[i]);
  device_.upload(s.position, rows);
  for (std::size_t i = 0; i < n; ++i)
    rows[i] = pack(state.velocity[i], state.felt_gravity.empty() ? 1 : state.felt_gravity[i]);
  device_.upload(s.velocity, rows);
  first_of_bdf2_ = state.earlier_shift.empty() || state.step == 0;
  if (plan_.bdf2 && !first_of_bdf2_) {
    for (std::size_t i = 0; i < n; ++i) rows[i] = pack(state.earlier_velocity[i]);
    device_.upload(s.earlier_velocity, rows);
    for (std::size_t i = 0; i < n; ++i) rows[i] = pack(state.earlier_shift[i]);
    device_.upload(s.earlier_shift, rows);
  }
  if (plan_.find("rotation") && !state.rotation.empty()) device_.upload(s.rotation, state.rotation);
  if (plan_.plastic && !state.rest.empty()) {
    device_.upload(s.rest, state.rest);
    device_.upload(s.flow, state.flow);
    device_.upload(s.linear_start, state.diagonal);
  }
  if (plan_.fluid_bonds && !state.bonds.near_rest.empty()) {
    device_.upload(fluid_->buffer("near_count"), state.bonds.near_count);
    device_.upload(fluid_->buffer("near"), state.bonds.near);
    device_.upload(fluid_->buffer("near_place_of"), state.bonds.near_place_of);
    device_.upload(fluid_->buffer("near_rest"), state.bonds.near_rest);
    if (plan_.fluid_flow) device_.upload(fluid_->buffer("fluid_flow"), state.bonds.fluid_flow);
  }
  if (s.emitter_count && !state.emitter_count.empty()) device_.upload(s.emitter_count, state.emitter_count);
  if (s.sunk && !state.sunk.empty()) device_.upload(s.sunk, state.sunk);
  if (fluid_ && fluid_->flow()) fluid_->flow()->reload();
  if (plan_.held) held_count_ = ~0u; // whoever is held at the new time is sent again
}

FrameOutput* Simulation::frame() {
  return frame_.get();
}

} // namespace pliant
