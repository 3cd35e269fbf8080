// Nozzles, the times of their layers, and room for what they emit.
#include "engine/model/emission.h"

#include "engine/core/error.h"
#include "engine/core/memory.h"
#include "engine/model/arrange.h"
#include "engine/scene/sample.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

/// Of a period: a layer that is due this much after a step's end counts as due at it.
constexpr double due = 1e-9;
/// At the peak of assembling and running a fluid, of each particle that there may be.
constexpr double bytes_a_particle = 1500;

Error wrong(const Scene& scene, const Emitter& emitter, const std::string& text) {
  return {ExitCode::usage,
          fmt::format("{}{}: emitter '{}': {}", scene.file.string(), emitter.typed_at, emitter.name, text)};
}

/// Directions across the nozzle; in two dimensions the second is z.
std::array<Vector3, 2> across(const Scene& scene, const Emitter& emitter) {
  const Vector3& out = emitter.direction;
  if (scene.simulation.dimension == 2) return {Vector3(-out.y(), out.x(), 0), Vector3(0, 0, 1)};
  Vector3 first = emitter.along.value_or(std::abs(out.x()) < 0.9 ? Vector3(1, 0, 0) : Vector3(0, 0, 1));
  first = (first - first.dot(out) * out).normalized();
  return {first, out.cross(first)};
}

std::vector<Vector3> nozzle_points(const Scene& scene, const Emitter& emitter) {
  const double spacing = scene.simulation.spacing, radius = emitter.disc.value_or(0);
  const std::array<double, 2> edges = emitter.rectangle.value_or(std::array{2 * radius, 2 * radius});
  const std::array<Vector3, 2> axes = across(scene, emitter);
  long long count[2];
  for (int a = 0; a < 2; ++a) {
    const auto edge = edges[static_cast<std::size_t>(a)];
    count[a] = a == 1 && scene.simulation.dimension == 2 ? 1 : std::llround(edge / spacing);
    if (count[a] < 1 || (edge < (1 - due) * spacing && !(a == 1 && scene.simulation.dimension == 2)))
      throw wrong(scene, emitter,
                  fmt::format("the nozzle is {:.4g} m wide, less than a spacing ({:.4g} m): widen it, or "
                              "take a smaller spacing",
                              edge, spacing));
  }
  std::vector<Vector3> points;
  for (long long y = 0; y < count[1]; ++y)
    for (long long x = 0; x < count[0]; ++x) {
      const double u = (double(x) - 0.5 * double(count[0] - 1)) * spacing,
                   v = (double(y) - 0.5 * double(count[1] - 1)) * spacing;
      if (emitter.disc && std::hypot(u, v) > (1 + due) * radius) continue;
      points.push_back(u * axes[0] + v * axes[1]);
    }
  return points;
}

/// Of the nozzle, and of where it lets go of its layers.
void check_place(const Scene& scene, const Emitter& emitter, const std::vector<Vector3>& nozzle) {
  const Vector3 held = scene.fluid.horizon * scene.simulation.spacing * emitter.direction;
  std::vector<Vector3> points = nozzle;
  for (const Vector3& p : nozzle) points.insert(points.end(), {p + held / 2, p + held});
  for (const Boundary& boundary : scene.boundaries) {
    const ShapeQuery query(boundary.shape, scene.file.parent_path());
    for (const Vector3& p : points)
      if (boundary.inside ? query.signed_distance(emitter.at + p) > 0
                          : query.signed_distance(emitter.at + p) < 0)
        throw wrong(scene, emitter,
                    fmt::format("the nozzle, or the {:.4g} m that it holds its layers, reaches into obstacle "
                                "'{}' at ({:.4g}, {:.4g}, {:.4g}) m: move one of them",
                                held.norm(), boundary.name, emitter.at.x() + p.x(), emitter.at.y() + p.y(),
                                emitter.at.z() + p.z()));
  }
  if (!scene.domain.given) return;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int a = 0; a < 3; ++a) {
      const double at = emitter.at[a] + points[i][a];
      if (scene.simulation.dimension == 2 && a == 2) continue;
      if (i >= nozzle.size() && scene.domain.periodic[static_cast<std::size_t>(a)]) continue;
      if (at < scene.domain.low[a] || at > scene.domain.high[a])
        throw wrong(scene, emitter,
                    fmt::format("the nozzle, or the {:.4g} m that it holds its layers, reaches to {} = "
                                "{:.4g} m, outside the domain, which goes from {:.4g} to {:.4g} m",
                                held.norm(), "xyz"[a], at, scene.domain.low[a], scene.domain.high[a]));
    }
}

void check_apart(const Scene& scene, const std::vector<Emission>& all) {
  for (std::size_t b = 1; b < all.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      const Emitter &one = scene.emitters[a], &other = scene.emitters[b];
      for (const Vector3& p : all[a].point)
        for (const Vector3& q : all[b].point)
          if ((one.at + p - other.at - q).norm() < 0.5 * scene.simulation.spacing)
            throw wrong(scene, other,
                        fmt::format("the nozzle overlaps that of emitter '{}' at ({:.4g}, {:.4g}, {:.4g}) "
                                    "m: move them apart, or make one of them",
                                    one.name, other.at.x() + q.x(), other.at.y() + q.y(),
                                    other.at.z() + q.z()));
    }
}

std::vector<Emission> nozzles(const Scene& scene) {
  std::vector<Emission> all;
  for (std::uint32_t e = 0; e < scene.emitters.size(); ++e) {
    const Emitter& emitter = scene.emitters[e];
    Emission one;
    one.emitter = e;
    one.body = static_cast<std::uint32_t>(scene.bodies.size()) + e;
    one.point = nozzle_points(scene, emitter);
    one.velocity = emitter.speed * emitter.direction;
    one.start = emitter.start, one.stop = emitter.stop;
    one.period = scene.simulation.spacing / emitter.speed;
    one.held = scene.fluid.horizon * one.period;
    if (emitter.stop < 1e300) one.most = one.layers(emitter.stop) * one.point.size();
    if (emitter.particles) one.most = std::min<std::uint64_t>(one.most, *emitter.particles);
    all.push_back(std::move(one));
  }
  return all;
}

std::uint64_t in_bodies(const Scene& scene, const Model& model) {
  std::uint64_t count = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) count += model.bodies[b].count;
  return count;
}

/// Room for each: what it emits until the scene is full.
void share_out(std::vector<Emission>& all, std::uint64_t free, bool leave) {
  std::vector<std::uint64_t> next(all.size(), 0), taken(all.size(), 0);
  if (leave) {
    for (Emission& one : all) one.count = static_cast<std::uint32_t>(std::min(one.most, free));
    return;
  }
  std::vector<bool> ended(all.size(), false);
  while (true) { // layer by layer, in order of birth
    std::size_t first = all.size();
    for (std::size_t e = 0; e < all.size(); ++e)
      if (!ended[e] && (first == all.size() || all[e].born(next[e]) < all[first].born(next[first])))
        first = e;
    if (first == all.size()) break;
    const std::uint64_t size = all[first].particles(next[first] + 1) - taken[first];
    if (size == 0 || size > free) {
      ended[first] = true;
      continue;
    }
    taken[first] += size, free -= size, ++next[first];
  }
  for (std::size_t e = 0; e < all.size(); ++e) all[e].count = static_cast<std::uint32_t>(taken[e]);
}

} // namespace

std::uint64_t Emission::layers(double time) const {
  const double passed = (std::min(time, stop) - start) / period;
  return passed > 0 ? static_cast<std::uint64_t>(std::max(std::ceil(passed - due), 0.0)) : 0;
}

std::uint64_t Emission::particles(std::uint64_t layers) const {
  return layers > most / point.size() ? most : std::min<std::uint64_t>(most, layers * point.size());
}

bool may_leave(const Scene& scene) {
  if (!scene.sinks.empty()) return true;
  const DomainSettings& domain = scene.domain;
  const auto closed = domain.periodic.begin() + (scene.simulation.dimension == 2 ? 2 : 3);
  return domain.given && std::find(domain.periodic.begin(), closed, false) != closed;
}

std::uint64_t capacity_of(const Scene& scene, const Model& model) {
  std::uint64_t count = in_bodies(scene, model);
  if (scene.simulation.capacity) return *scene.simulation.capacity;
  for (const Emission& one : nozzles(scene)) {
    if (one.most == UINT64_MAX)
      throw wrong(scene, scene.emitters[one.emitter],
                  "it never ends: say how many particles there may be at once, [simulation] capacity, or "
                  "give it a stop or particles");
    count += one.most;
  }
  return count;
}

void add_emitters(const Scene& scene, Model& model) {
  const std::uint64_t bodies = in_bodies(scene, model);
  if (scene.simulation.capacity && bodies > *scene.simulation.capacity)
    throw Error(ExitCode::usage, fmt::format("{}{}: simulation.capacity = {} is below the {} particles that "
                                             "the bodies have at the start",
                                             scene.file.string(), scene.simulation.capacity_at,
                                             *scene.simulation.capacity, bodies));
  if (scene.emitters.empty()) return;
  std::vector<Emission> all = nozzles(scene);
  for (const Emission& one : all) check_place(scene, scene.emitters[one.emitter], one.point);
  check_apart(scene, all);
  const std::uint64_t capacity = capacity_of(scene, model);
  if (capacity >= UINT32_MAX / 2)
    throw Error(ExitCode::too_large, fmt::format("{}: {} particles are more than 31 bits can count",
                                                 scene.file.string(), capacity));
  const bool leave = may_leave(scene);
  share_out(all, leave ? capacity : capacity - bodies, leave);
  double room = double(bodies);
  for (const Emission& one : all) room += double(one.count);
  require_memory(fmt::format("{}{}: the scene has room for {:.0f} particles and needs", scene.file.string(),
                             scene.simulation.capacity_at, room),
                 room * bytes_a_particle, available_memory(), model.spacing);
  for (const Emission& one : all) {
    const Emitter& emitter = scene.emitters[one.emitter];
    BodyModel& body = model.bodies.emplace_back();
    body.name = emitter.name;
    body.origin = emitter.at;
    body.color = emitter.color.value_or(scene.material(emitter.material)->color);
    body.emitted = true;
    const auto material =
        static_cast<std::uint32_t>(scene.material(emitter.material) - scene.materials.data());
    const double volume = std::pow(model.spacing, 2) * (scene.simulation.dimension == 2 ? 1 : model.spacing);
    if (scene.simulation.dimension == 2) body.thickness = 1;
    BodyParticles particles;
    particles.first_id = static_cast<std::uint32_t>(model.count());
    Arrangement& part = particles.arrangement;
    for (std::uint32_t k = 0; k < one.count; ++k) {
      part.reference.push_back(one.point[k % one.point.size()]);
      part.original.push_back(k);
      particles.position.push_back(emitter.at + part.reference.back());
    }
    part.component.assign(one.count, 0);
    part.components = one.count > 0 ? 1 : 0;
    part.bonds.begin.assign(one.count + 1, 0);
    particles.velocity.assign(one.count, one.velocity);
    particles.volume.assign(one.count, volume);
    particles.mass.assign(one.count, scene.materials[material].density * volume);
    particles.material.assign(one.count, material);
    append(model, one.body, Law::fluid, std::move(particles));
  }
}

std::vector<Emission> emissions(const Scene& scene, const Model& model) {
  std::vector<Emission> all = nozzles(scene);
  for (Emission& one : all) {
    one.first = model.bodies[one.body].first;
    one.count = model.bodies[one.body].count;
  }
  return all;
}

} // namespace pliant
