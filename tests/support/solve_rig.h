// The parts of a solve on a device without a simulation around them: forces, their derivative, and the
// preconditioner, applied to whatever vectors a test gives.
#pragma once

#include "engine/model/hierarchy.h"
#include "engine/solver/contact.h"
#include "engine/solver/elasticity.h"
#include "engine/solver/failure.h"
#include "engine/solver/multilevel.h"
#include "engine/solver/preconditioner.h"
#include "engine/solver/state.h"
#include "kernels/newton_product.h"
#include "shaders/common/solver.glsl"
#include "tests/support/bodies.h"

namespace pliant::test {

class SolveRig {
public:
  Plan plan;
  bool convex = false; ///< the derivative is kept positive

  /// Held particles are those whose inertia is negative, as a simulation marks them.
  SolveRig(Device& device, const Scene& scene, const Model& model)
      : plan(make_plan(scene, model, slice_bonds(model), {})), device_(device), scene_(scene), model_(model),
        elasticity_(device, scene, model, state_, plan.share_row), held_(model.count(), false) {
    for (const BufferSpec& spec : plan.buffers)
      if (Buffer* buffer = state_.find(spec.name))
        *buffer = device.allocate(spec.name, spec.type, spec.count);
    for (const Held& held : model.held) held_[held.particle] = true;
    upload();
    if (plan.failure) failure_ = std::make_unique<Failure>(device, scene, model, plan, state_, elasticity_);
    if (plan.boundaries || plan.pairs)
      contacts_ = std::make_unique<Contacts>(device, scene, model, Vector3::Zero(), contact_use(plan.method));
    preconditioner_ =
        make_preconditioner({device_, scene_, model_, plan, state_, elasticity_, contacts_.get()});
    if (contacts_) contacts_->begin_step(0, step(), contact_state(state_));
  }

  double step() const { return scene_.simulation.time_step; }
  SimulationState& state() { return state_; }
  BufferStorage* contact_block() const { return contacts_ ? contacts_->block() : nullptr; }

  /// Elastic and contact forces at displacements u, N; what product() and precondition() read is of the last
  /// call.
  std::vector<Vector3> forces(const std::vector<Vector3>& u) {
    device_.upload(state_.displacement, groups(u));
    device_.copy(state_.displacement, state_.best_iterate);
    std::vector<double> solver(SOLVER_ENTRIES, 0.0);
    solver[SOLVER_LINEAR] = solver[SOLVER_TAKEN] = 1;
    solver[SOLVER_CONVEX] = convex;
    device_.upload(state_.solver, solver);
    elasticity_.begin();
    elasticity_.state(state_.displacement);
    elasticity_.force();
    elasticity_.tangent(state_.displacement); // once: products write over what it reads
    if (plan.method.potential) elasticity_.energy(state_.displacement);
    if (contacts_) {
      contacts_->find(contact_state(state_));
      contacts_->add_forces(contact_state(state_));
    }
    diagonal_ = device_.download_real4(state_.force);
    return vectors(state_.force);
  }
  /// After forces(): (M / h^2 - df/du) p, N.
  std::vector<Vector3> product(const std::vector<Vector3>& p) {
    device_.upload(state_.direction, groups(p));
    elasticity_.product(state_.direction);
    if (contacts_) contacts_->add_product(contact_state(state_), state_.best_iterate, state_.direction);
    device_.run(kernels::newton_product::Args{.threads = count(),
                                              .obstacles = plan.boundaries,
                                              .inertia_target = state_.inertia_target,
                                              .direction = state_.direction,
                                              .contact_block = contact_block(),
                                              .solver = state_.solver,
                                              .force = state_.force,
                                              .solve_partial = state_.solve_partial});
    return vectors(state_.force);
  }
  /// Of bodies that break, as at the end of a step with displacements u.
  void break_bonds(const std::vector<Vector3>& u) {
    device_.upload(state_.best_iterate, groups(u));
    failure_->break_bonds();
  }
  Failure* failure() { return failure_.get(); }
  /// J, at displacements u.
  double energy(const std::vector<Vector3>& u) {
    forces(u);
    elasticity_.energy(state_.displacement);
    double sum = 0;
    for (const double one : device_.download_real(state_.energy, 0, count())) sum += one;
    return sum;
  }
  /// After forces(): what the preconditioner has of the iterate.
  void refresh() {
    preconditioner_->begin({.step = step(), .stiffness_number = 1, .floor = 0, .cap = 1});
    preconditioner_->refresh();
  }
  /// After refresh(): P^-1 r, m, with the share `relief` of the stiffness in the diagonal.
  std::vector<Vector3> precondition(const std::vector<Vector3>& r, double relief = 1) {
    std::vector<Real4<double>> rows = groups(r);
    for (std::size_t i = 0; i < rows.size(); ++i)
      rows[i] = held_[i] ? Real4<double>{0, 0, 0, 0}
                         : Real4<double>{rows[i].x, rows[i].y, rows[i].z,
                                         1 / (inertia(i) + relief * diagonal_[i].w)};
    device_.upload(state_.residual, rows);
    preconditioner_->apply();
    return vectors(state_.preconditioned);
  }
  std::vector<Vector3> vectors(const BufferStorage* buffer) {
    std::vector<Vector3> result;
    for (const Real4<double>& v : device_.download_real4(buffer, 0, count()))
      result.emplace_back(v.x, v.y, v.z);
    return result;
  }

private:
  std::uint32_t count() const { return static_cast<std::uint32_t>(model_.count()); }
  double inertia(std::size_t i) const { return model_.mass[i] / (step() * step()); }
  static std::vector<Real4<double>> groups(const std::vector<Vector3>& v) {
    std::vector<Real4<double>> rows;
    rows.reserve(v.size());
    for (const Vector3& one : v) rows.push_back({one.x(), one.y(), one.z(), 0});
    return rows;
  }

  void upload() {
    const std::size_t n = model_.count();
    std::vector<Real4<double>> position(n), linear(n), rotation(n), target(n), origin;
    const std::vector<double> stiffness = diagonal_stiffness(model_);
    for (const BodyModel& body : model_.bodies)
      origin.push_back({body.origin.x(), body.origin.y(), body.origin.z(), 1});
    for (std::size_t i = 0; i < n; ++i) {
      const BodyModel& body = model_.bodies[model_.body[i]];
      const Vector3 y = model_.position[i] - body.origin;
      const Eigen::Quaterniond q(body.axes);
      position[i] = {y.x(), y.y(), y.z(), model_.mass[i]};
      linear[i] = {0, 0, 0, stiffness[i]};
      rotation[i] = {q.x(), q.y(), q.z(), q.w()};
      target[i] = {0, 0, 0, held_[i] ? -1 : inertia(i)};
    }
    device_.upload(state_.position, position);
    device_.upload(state_.linear_start, linear);
    device_.upload(state_.inertia_target, target);
    if (plan.find("rotation")) device_.upload(state_.rotation, rotation);
    elasticity_.upload();
    device_.upload(state_.origin, origin);
    device_.upload(state_.owner, model_.body);
    const SlicedBonds bonds = slice_bonds(model_);
    std::vector<std::uint32_t> begins(bonds.slice_begin), packed(2 * bonds.neighbour.size());
    std::vector<double> weights(packed.size());
    for (std::uint32_t& begin : begins) begin /= slice_width;
    for (std::size_t e = 0; e < bonds.neighbour.size(); ++e) {
      const std::size_t at = e / 16 * 32 + e % 16;
      packed[at] = bonds.neighbour[e], packed[at + 16] = bonds.offset[e];
      weights[at] = bonds.weight_out[e], weights[at + 16] = bonds.weight_in[e];
    }
    device_.upload(state_.slice_begin, begins);
    device_.upload(state_.bond, packed);
    device_.upload(state_.weight, weights);
  }

  Device& device_;
  const Scene& scene_;
  const Model& model_;
  SimulationState state_;
  Elasticity elasticity_;
  std::vector<bool> held_;
  std::unique_ptr<Failure> failure_;
  std::unique_ptr<Contacts> contacts_;
  std::unique_ptr<Preconditioner> preconditioner_;
  std::vector<Real4<double>> diagonal_;
};

} // namespace pliant::test
