// Where a body's particles are and how fast they move at t = 0.
#pragma once

#include "engine/model/arrange.h"

namespace pliant {

/// Centre of mass, m; zero where there are no particles.
Vector3 centre_of_mass(const std::vector<Vector3>& position, const std::vector<double>& mass);

/// A body's `deformed` region with the particles that it selects.
struct DeformedPart {
  std::vector<std::uint32_t> particles;
  const DeformedRegion* region = nullptr;
};

/// Applies the parts in their order, a body's `deform` and its `start` to rest positions, then sets
/// velocities from `velocity` and `spin`. About the centre of mass c of the rest positions: "flat" puts all
/// on the plane x = c.x, "line" on the line along y, "point" on c; "mirror" reflects x; "random" is uniform
/// in the box of the deformed body, by a fixed seed and the particle's id, so that the order of the particles
/// does not matter.
void set_initial_state(const Body& body, const std::vector<DeformedPart>& parts, BodyParticles& particles);

} // namespace pliant
