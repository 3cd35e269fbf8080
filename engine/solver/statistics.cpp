// Rows of statistics, and forces and energies for tests and tools.
#include "engine/core/error.h"
#include "engine/solver/elasticity.h"
#include "engine/solver/failure.h"
#include "engine/solver/fluid.h"
#include "engine/solver/global_step.h"
#include "engine/solver/plasticity.h"
#include "engine/solver/simulation.h"
#include "engine/solver/state.h"
#include "kernels/all.h"
#include "shaders/common/solver.glsl"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <numeric>

namespace pliant {

void Simulation::write_statistics() {
  if (!plan_.statistics && !plan_.divergence) return;
  SimulationState& s = *state_;
  device_.enter(plan_.statistics ? "statistics" : "divergence");
  const auto chunks = static_cast<std::uint32_t>(chunks_.chunk.size());
  device_.run(kernels::statistics_chunk::Args{.threads = chunks * kernels::statistics_chunk::group_size,
                                              .energies = plan_.statistics && plan_.energy,
                                              .chunk = s.chunk,
                                              .position = s.position,
                                              .velocity = s.velocity,
                                              .energy = s.energy,
                                              .displacement = fluid_ ? s.velocity : s.best_iterate,
                                              .chunk_sum = s.chunk_sum});
  const auto row = static_cast<std::uint32_t>(step_ % statistics_rows);
  device_.run(kernels::statistics_total::Args{.threads = kernels::statistics_total::group_size,
                                              .chunk_count = chunks,
                                              .row = row,
                                              .chunk_sum = s.chunk_sum,
                                              .solver = s.solver,
                                              .statistics = s.statistics});
  const std::size_t bytes = 16 * element_bytes(Type::real, device_.info().precision);
  pending_.push_back({step_ + 1, device_.request(s.statistics, row * bytes, bytes), nullptr, nullptr, nullptr,
                      nullptr, nullptr, plastic_rounds_, earlier_iterations_});
  if (failure_) pending_.back().fracture = failure_->sums(row);
  if (plastic_) pending_.back().plastic = plastic_->sums(row);
  if (fluid_) pending_.back().fluid = fluid_->sums(row), pending_.back().forces = fluid_->force_sums(row);
  if (fluid_) pending_.back().bonds = fluid_->bond_sums(row);
  if (fluid_ && fluid_->flow()) {
    pending_.back().emitted = fluid_->flow()->emitted();
    pending_.back().sunk = fluid_->flow()->sunk();
  }
}

StepStatistics Simulation::row(std::span<const std::byte> bytes, std::uint64_t step) const {
  double value[16];
  for (std::size_t k = 0; k < 16; ++k) {
    if (device_.info().precision == Precision::double_precision) {
      std::memcpy(&value[k], bytes.data() + 8 * k, 8);
    } else {
      float narrow = 0;
      std::memcpy(&narrow, bytes.data() + 4 * k, 4);
      value[k] = narrow;
    }
  }
  StepStatistics s;
  s.step = step;
  s.time = static_cast<double>(step) * time_step_;
  s.kinetic_energy = value[0];
  s.elastic_energy = value[1];
  s.largest_speed = value[2];
  s.not_finite = static_cast<std::size_t>(value[3]);
  s.momentum = {value[4], value[5], value[6]};
  s.largest_displacement = value[7];
  s.first_residual = value[8];
  s.last_residual = value[9];
  s.residual = value[8] > 0 ? value[9] / value[8] : 0;
  s.floor = value[10];
  s.iterations = static_cast<unsigned>(value[11]);
  s.restarts = static_cast<unsigned>(value[12]);
  s.reason = static_cast<StopReason>(static_cast<int>(value[13]));
  if (plan_.method.potential) {
    s.energy_rises = static_cast<unsigned>(value[14]);
    s.energy_error = value[15];
  }
  if (fluid_) { // its rows hold velocities where those of others hold displacements
    s.largest_displacement *= solve_step_;
    if (plan_.fluid_bonds) return s; // of the elastic solve
    s.iterations = scene_.fluid.density_iterations;
    s.reason = StopReason::cap;
  }
  return s;
}

namespace {

double real_at(std::span<const std::byte> bytes, std::size_t index, bool wide) {
  double value = 0;
  float narrow = 0;
  if (wide) {
    std::memcpy(&value, bytes.data() + 8 * index, 8);
    return value;
  }
  std::memcpy(&narrow, bytes.data() + 4 * index, 4);
  return static_cast<double>(narrow);
}

std::size_t sum_of(std::span<const std::byte> bytes) {
  std::vector<std::uint32_t> counts(bytes.size() / sizeof(std::uint32_t));
  std::memcpy(counts.data(), bytes.data(), bytes.size());
  return std::accumulate(counts.begin(), counts.end(), std::size_t{0});
}

/// The row of a divided step from those of its parts.
StepStatistics joined(const StepStatistics& earlier, const StepStatistics& later) {
  StepStatistics both = later;
  both.iterations += earlier.iterations;
  both.restarts += earlier.restarts;
  both.energy_rises += earlier.energy_rises;
  both.energy_error = std::max(earlier.energy_error, later.energy_error);
  both.reason = std::max(earlier.reason, later.reason);
  both.residual = std::max(earlier.residual, later.residual);
  both.largest_speed = std::max(earlier.largest_speed, later.largest_speed);
  both.largest_displacement += earlier.largest_displacement;
  both.not_finite = std::max(earlier.not_finite, later.not_finite);
  both.yielding = std::max(earlier.yielding, later.yielding);
  both.plastic_rounds += earlier.plastic_rounds;
  both.yield_excess = std::max(earlier.yield_excess, later.yield_excess);
  both.viscosity_iterations += earlier.viscosity_iterations;
  both.viscosity_residual = std::max(earlier.viscosity_residual, later.viscosity_residual);
  both.density_error = std::max(earlier.density_error, later.density_error);
  both.largest_density_error = std::max(earlier.largest_density_error, later.largest_density_error);
  both.neighbours_dropped = std::max(earlier.neighbours_dropped, later.neighbours_dropped);
  both.lists_full = std::max(earlier.lists_full, later.lists_full);
  return both;
}

} // namespace

std::vector<StepStatistics> Simulation::take_statistics(bool wait) {
  std::vector<StepStatistics> rows;
  const auto arrived = [this] { // with all parts of a divided step
    std::size_t last = 0;
    while (last + 1 < pending_.size() && pending_[last + 1].step == pending_.front().step) ++last;
    return pending_[last].readback->ready();
  };
  while (!pending_.empty() &&
         (wait || (!rows.empty() && rows.back().step == pending_.front().step) || arrived())) {
    StepStatistics next = row(pending_.front().readback->wait(), pending_.front().step);
    if (pending_.front().fracture) {
      const bool wide = device_.info().precision == Precision::double_precision;
      const std::span<const std::byte> sums = pending_.front().fracture->wait();
      next.broken_bonds = static_cast<std::size_t>(std::lround(real_at(sums, 0, wide)));
      next.fracture_energy = real_at(sums, 1, wide);
    }
    if (pending_.front().plastic) {
      const bool wide = device_.info().precision == Precision::double_precision;
      const std::span<const std::byte> sums = pending_.front().plastic->wait();
      next.yielding = static_cast<std::size_t>(std::lround(real_at(sums, 0, wide)));
      next.plastic_work = real_at(sums, 1, wide);
      next.plastic_strain = real_at(sums, 2, wide);
      next.plastic_volume = real_at(sums, 3, wide);
      next.yield_excess = real_at(sums, 4, wide);
      next.plastic_rounds = pending_.front().plastic_rounds;
      next.iterations += pending_.front().earlier_iterations;
    }
    if (pending_.front().fluid) {
      const bool wide = device_.info().precision == Precision::double_precision;
      const std::span<const std::byte> sums = pending_.front().fluid->wait();
      const double inside = real_at(sums, 0, wide);
      next.density_error = inside > 0 ? real_at(sums, 1, wide) / inside : 0;
      next.largest_density_error = std::max(real_at(sums, 2, wide), 0.0);
      next.density_slope = real_at(sums, 3, wide);
      next.removed = static_cast<std::size_t>(std::lround(real_at(sums, 4, wide)));
      next.neighbours_dropped = static_cast<std::size_t>(std::lround(real_at(sums, 5, wide)));
      next.lists_full = static_cast<std::size_t>(std::lround(real_at(sums, 6, wide)));
      if (!plan_.fluid_bonds) next.residual = real_at(sums, 7, wide);
      if (const FluidFlow* flow = fluid_->flow()) {
        next.emitted = pending_.front().emitted;
        if (pending_.front().sunk) next.sunk = sum_of(pending_.front().sunk->wait());
        next.present = model_.count() - next.removed; // column 4: all that have no mass
        next.removed = flow->bodies() + next.emitted - next.sunk - next.present;
      }
    }
    if (pending_.front().bonds) {
      const bool wide = device_.info().precision == Precision::double_precision;
      const std::span<const std::byte> sums = pending_.front().bonds->wait();
      next.yielding = static_cast<std::size_t>(std::lround(real_at(sums, 0, wide)));
      next.plastic_work = real_at(sums, 1, wide);
      next.plastic_strain = real_at(sums, 2, wide);
      next.plastic_volume = real_at(sums, 3, wide);
      next.yield_excess = real_at(sums, 4, wide);
      next.elastic_energy = real_at(sums, 5, wide);
      next.plastic_rounds = 1;
    }
    if (pending_.front().forces) {
      const bool wide = device_.info().precision == Precision::double_precision;
      const std::span<const std::byte> sums = pending_.front().forces->wait();
      const double inside = real_at(sums, 0, wide);
      next.unevenness = inside > 0 ? real_at(sums, 1, wide) / inside : 0;
      next.viscosity_iterations = static_cast<unsigned>(std::lround(real_at(sums, 3, wide)));
      next.viscosity_residual = real_at(sums, 4, wide);
    }
    pending_.pop_front();
    if (rows.empty() || rows.back().step != next.step)
      rows.push_back(next);
    else
      rows.back() = joined(rows.back(), next);
  }
  return rows;
}

void Simulation::load_displacement(const std::vector<Vector3>& positions) {
  if (fluid_) throw Error(ExitCode::usage, "a scene of fluids has no elastic forces");
  SimulationState& s = *state_;
  const std::vector<Real4<double>> y = device_.download_real4(s.position),
                                   o = device_.download_real4(s.origin);
  if (positions.size() != y.size())
    throw Error(ExitCode::internal,
                fmt::format("{} positions given for {} particles", positions.size(), y.size()));
  std::vector<Real4<double>> u(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    const Vector3 x = positions[i] - scene_origin_;
    const Real4<double>& body = o[model_.body[i]];
    u[i] = {x.x() - body.x - y[i].x, x.y() - body.y - y[i].y, x.z() - body.z - y[i].z, 0};
  }
  device_.upload(s.displacement, u);
  device_.copy(s.displacement, s.best_iterate);
  device_.upload(s.solver, std::vector<double>(SOLVER_ENTRIES, 0.0));
  elasticity_->begin();
  elasticity_->state(s.displacement);
}

std::vector<Vector3> Simulation::elastic_forces(const std::vector<Vector3>& positions) {
  load_displacement(positions);
  elasticity_->force();
  std::vector<Vector3> result;
  for (const Real4<double>& f : device_.download_real4(state_->force)) result.emplace_back(f.x, f.y, f.z);
  return result;
}

double Simulation::elastic_energy(const std::vector<Vector3>& positions) {
  if (!plan_.energy) throw Error(ExitCode::internal, "energies are not in this simulation's plan");
  load_displacement(positions);
  device_.enter("statistics");
  elasticity_->energy(state_->best_iterate);
  double sum = 0;
  for (double e : device_.download_real(state_->energy)) sum += e;
  return sum;
}

std::vector<Vector3> Simulation::iterate_positions() {
  SimulationState& s = *state_;
  const std::vector<Real4<double>> y = device_.download_real4(s.position),
                                   u = device_.download_real4(s.best_iterate),
                                   o = device_.download_real4(s.origin);
  std::vector<Vector3> world(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    const Real4<double>& body = o[model_.body[i]];
    world[i] =
        scene_origin_ + Vector3(body.x + y[i].x + u[i].x, body.y + y[i].y + u[i].y, body.z + y[i].z + u[i].z);
  }
  return world;
}

double Simulation::potential(const std::vector<Vector3>& positions) {
  if (!plan_.energy) throw Error(ExitCode::internal, "energies are not in this simulation's plan");
  return evaluate(positions).potential;
}

Simulation::Evaluation Simulation::evaluate(const std::vector<Vector3>& positions) {
  SimulationState& s = *state_;
  load_displacement(positions);
  elasticity_->force();
  if (plan_.energy) elasticity_->energy(s.best_iterate);
  if (contacts_) {
    contacts_->find(contact_state(s));
    contacts_->add_forces(contact_state(s));
  }
  const std::vector<Real4<double>> target = device_.download_real4(s.inertia_target),
                                   u = device_.download_real4(s.best_iterate),
                                   force = device_.download_real4(s.force);
  Evaluation sum;
  if (plan_.energy)
    for (double e : device_.download_real(s.energy)) sum.potential += e;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double inertia = target[i].w;
    if (inertia < 0) continue; // held
    const Vector3 away(target[i].x - u[i].x, target[i].y - u[i].y, target[i].z - u[i].z);
    const Vector3 f(force[i].x, force[i].y, force[i].z);
    sum.potential += inertia / 2 * away.squaredNorm();
    sum.residual += (inertia * away + f).squaredNorm() / (inertia + force[i].w);
  }
  sum.residual = std::sqrt(sum.residual);
  if (!plan_.energy) sum.potential = std::numeric_limits<double>::quiet_NaN();
  return sum;
}

void Simulation::start_from(const std::vector<Vector3>& positions) {
  SimulationState& s = *state_;
  const std::vector<Real4<double>> y = device_.download_real4(s.position),
                                   o = device_.download_real4(s.origin),
                                   target = device_.download_real4(s.inertia_target);
  std::vector<Real4<double>> u = device_.download_real4(s.displacement);
  for (std::size_t i = 0; i < u.size(); ++i) {
    if (target[i].w < 0) continue;
    const Real4<double>& body = o[model_.body[i]];
    const Vector3 x =
        positions[i] - scene_origin_ - Vector3(body.x + y[i].x, body.y + y[i].y, body.z + y[i].z);
    u[i] = {x.x(), x.y(), x.z(), 0};
  }
  device_.upload(s.displacement, u);
  device_.copy(s.displacement, s.best_iterate);
  global_step_->begin({.step = solve_step_,
                       .stiffness_number = stiffness_number_,
                       .floor = floor_,
                       .rounding = rounding_,
                       .cap = scene_.solver.iterations});
}

std::string Simulation::hash() {
  const std::vector<Vector3> x = positions(), v = velocities();
  std::vector<std::size_t> by_id(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) by_id[model_.id[i]] = i;
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&hash](double value) {
    unsigned char bytes[8];
    std::memcpy(bytes, &value, 8);
    for (unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
  };
  for (std::size_t i : by_id)
    for (int c = 0; c < 3; ++c) mix(x[i][c]), mix(v[i][c]);
  return fmt::format("{:016x}", hash);
}

void Simulation::measure(bool on) {
  device_.measure(on);
}

} // namespace pliant
