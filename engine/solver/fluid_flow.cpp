// Runs the kernels of emitters and sinks.
#include "engine/solver/fluid_flow.h"

#include "engine/core/error.h"
#include "engine/solver/contact_obstacles.h"
#include "engine/solver/fluid.h"
#include "engine/solver/state.h"
#include "shaders/common/contact.glsl"

#include "kernels/fluid_emit.h"
#include "kernels/fluid_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace pliant {

namespace {

/// Regions of sinks, described as obstacles are.
Obstacles sinks_of(const Scene& scene) {
  Scene regions;
  regions.file = scene.file;
  for (const Sink& sink : scene.sinks) {
    Boundary& region = regions.boundaries.emplace_back();
    region.name = sink.name;
    region.shape = sink.region;
    region.typed_at = sink.typed_at;
  }
  return {regions, 0, scene.simulation.spacing, true};
}

} // namespace

FluidFlowPlan plan_flow(const Scene& scene, const Model& model) {
  FluidFlowPlan plan;
  plan.emitters = static_cast<std::uint32_t>(scene.emitters.size());
  plan.sinks = static_cast<std::uint32_t>(scene.sinks.size());
  for (const Emission& one : emissions(scene, model)) {
    plan.points += one.point.size();
    plan.widest = std::max(plan.widest, one.point.size());
  }
  return plan;
}

void list_flow(FluidFlowPlan& plan, std::vector<BufferSpec>& buffers, std::vector<KernelSpec>& kernels) {
  if (plan.emitters > 0) {
    buffers.push_back({"emitter_point", Type::real4, plan.points, "emitters"});
    buffers.push_back({"emitter_slot", Type::uint, plan.widest, "emitters"});
    plan.counts.push_back({"emitter_count", Type::uint, std::size_t{2} * plan.emitters, "emitters"});
    kernels.push_back(kernel_variant(kernels::fluid_emit::Args{}, "emitters"));
  }
  if (plan.sinks > 0) {
    buffers.push_back({"sink", Type::real4, std::size_t{OBSTACLES} * OBSTACLE_ROWS, "sinks"});
    plan.counts.push_back({"sunk", Type::uint, plan.sinks, "sinks"});
    kernels.push_back(kernel_variant(kernels::fluid_sink::Args{}, "sinks"));
  }
}

FluidFlow::FluidFlow(Device& device, const Scene& scene, const Model& model, const Fluid& fluid,
                     SimulationState& state, const Vector3& origin, const Vector3& base)
    : device_(device), scene_(scene), fluid_(fluid), state_(state), base_(base),
      emissions_(emissions(scene, model)), leave_(may_leave(scene)), born_(scene.emitters.size(), 0),
      ended_(scene.emitters.size(), 0) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) bodies_ += model.bodies[b].count;
  if (!emissions_.empty()) {
    capacity_ = capacity_of(scene, model);
    std::vector<Real4<double>> points;
    for (const Emission& one : emissions_) {
      first_point_.push_back(static_cast<std::uint32_t>(points.size()));
      const double mass = one.count > 0 ? model.mass[one.first] : 0;
      for (const Vector3& p : one.point) points.push_back({p.x(), p.y(), p.z(), mass});
    }
    device_.upload(fluid.buffer("emitter_point"), points);
  }
  if (!scene.sinks.empty()) device_.upload(fluid.buffer("sink"), sinks_of(scene).table(0, 0, origin));
}

std::uint64_t FluidFlow::emitted() const {
  return std::accumulate(born_.begin(), born_.end(), std::uint64_t{0});
}

void FluidFlow::reload() {
  if (emissions_.empty()) return;
  const std::vector<std::uint32_t> counts = device_.download_uint(state_.emitter_count);
  for (std::size_t e = 0; e < emissions_.size(); ++e) born_[e] = counts[2 * e], ended_[e] = counts[2 * e + 1];
}

/// Gives a layer of `size` particles its slots: `fresh` of its emitter's were used before this one; false
/// where the scene has no room. `there`: who has mass or is born `earlier` in the step; read when it is
/// needed.
bool FluidFlow::fill(FluidBirths::Layer& layer, std::uint64_t size, std::uint64_t fresh,
                     const FluidBirths& earlier, std::vector<bool>& there) {
  const Emission& one = emissions_[layer.emitter];
  std::uint64_t count = bodies_ + emitted() + size;
  for (const FluidBirths::Layer& other : earlier.layers) count += other.slot.size();
  if (there.empty() && count <= capacity_ && fresh + size <= one.count) {
    layer.slot.resize(size);
    std::iota(layer.slot.begin(), layer.slot.end(), one.first + static_cast<std::uint32_t>(fresh));
    return true;
  }
  if (!leave_) return false;
  if (there.empty()) {
    for (const Real4<double>& y : device_.download_real4(state_.position)) there.push_back(y.w != 0);
    for (const FluidBirths::Layer& other : earlier.layers)
      for (const std::uint32_t i : other.slot) there[i] = true;
  }
  if (static_cast<std::uint64_t>(std::count(there.begin(), there.end(), true)) + size > capacity_)
    return false;
  for (std::uint32_t i = one.first; layer.slot.size() < size && i < one.first + one.count; ++i)
    if (!there[i]) layer.slot.push_back(i);
  if (layer.slot.size() < size) return false;
  for (const std::uint32_t i : layer.slot) there[i] = true;
  return true;
}

FluidBirths FluidFlow::make_room(double begin, double end) {
  FluidBirths births;
  std::vector<std::pair<double, std::size_t>> due; // in order of birth
  for (std::size_t e = 0; e < emissions_.size(); ++e) {
    const std::uint64_t last = emissions_[e].layers(end);
    for (std::uint64_t k = emissions_[e].layers(begin); k < last; ++k)
      due.emplace_back(emissions_[e].born(k), e);
  }
  std::stable_sort(due.begin(), due.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::uint64_t> born(born_.begin(), born_.end());
  std::vector<std::uint32_t> ended(ended_);
  std::vector<bool> there;
  for (const auto& [time, e] : due) {
    const Emission& one = emissions_[e];
    const std::uint64_t size =
        std::min<std::uint64_t>(one.point.size(), one.most - std::min(one.most, born[e]));
    if (ended[e] || size == 0) continue;
    FluidBirths::Layer layer{e, time, {}};
    if (!fill(layer, size, born[e], births, there)) {
      const Emitter& emitter = scene_.emitters[e];
      if (!emitter.stops)
        throw Error(
            ExitCode::too_large,
            fmt::format("{}{}: emitter '{}': there is no room for its next {} particles at t = {:.6g} "
                        "s: the scene may hold {}. Give [simulation] capacity more, the emitter a "
                        "stop, or when_full = \"stop\"",
                        scene_.file.string(), emitter.typed_at, emitter.name, size, time, capacity_));
      ended[e] = 1;
      births.ended.push_back(e);
      continue;
    }
    born[e] += size;
    births.layers.push_back(std::move(layer));
  }
  return births;
}

void FluidFlow::end_step(const FluidBirths& births, double end) {
  if (!scene_.sinks.empty()) {
    device_.enter("sinks");
    device_.run(kernels::fluid_sink::Args{.threads = fluid_.plan().model.count,
                                          .sinks = static_cast<std::uint32_t>(scene_.sinks.size()),
                                          .base_x = base_.x(),
                                          .base_y = base_.y(),
                                          .base_z = base_.z(),
                                          .sink = fluid_.buffer("sink"),
                                          .fluid_kind = fluid_.buffer("fluid_kind"),
                                          .origin = state_.origin,
                                          .position = state_.position,
                                          .velocity = state_.velocity,
                                          .sunk = state_.sunk});
  }
  if (births.layers.empty() && births.ended.empty()) return;
  device_.enter("emitters");
  for (const FluidBirths::Layer& layer : births.layers) {
    const Emission& one = emissions_[layer.emitter];
    const double age = end - layer.born, free = std::max(age - one.held, 0.0);
    const Vector3 fall = free * scene_.simulation.gravity;
    const Vector3 flown = age * one.velocity + free / 2 * fall, velocity = one.velocity + fall;
    device_.upload(fluid_.buffer("emitter_slot"), layer.slot);
    device_.run(kernels::fluid_emit::Args{.threads = static_cast<std::uint32_t>(layer.slot.size()),
                                          .emitter = static_cast<std::uint32_t>(layer.emitter),
                                          .first = first_point_[layer.emitter],
                                          .flown_x = flown.x(),
                                          .flown_y = flown.y(),
                                          .flown_z = flown.z(),
                                          .held = std::max(one.held - age, 0.0),
                                          .speed_x = velocity.x(),
                                          .speed_y = velocity.y(),
                                          .speed_z = velocity.z(),
                                          .emitter_slot = fluid_.buffer("emitter_slot"),
                                          .emitter_point = fluid_.buffer("emitter_point"),
                                          .position = state_.position,
                                          .velocity = state_.velocity,
                                          .emitter_count = state_.emitter_count});
    born_[layer.emitter] += static_cast<std::uint32_t>(layer.slot.size());
  }
  for (const std::size_t e : births.ended) {
    ended_[e] = 1;
    device_.upload(state_.emitter_count, std::array{1u}, 2 * e + 1);
  }
}

std::vector<std::uint32_t> FluidFlow::sunk_by() const {
  return scene_.sinks.empty() ? std::vector<std::uint32_t>{} : device_.download_uint(state_.sunk);
}

std::unique_ptr<Readback> FluidFlow::sunk() {
  if (scene_.sinks.empty()) return nullptr;
  device_.enter("sinks");
  return device_.request(state_.sunk, 0, state_.sunk->bytes());
}

} // namespace pliant
