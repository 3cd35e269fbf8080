// One body's particles put in order and bonded; then many bodies put into one model.
#pragma once

#include "engine/model/model.h"

#include <functional>

namespace pliant {

/// A body's reference configuration: snapped, sorted and bonded. Indices are the body's own.
struct Arrangement {
  std::vector<Vector3> reference;       ///< m, multiples of spacing / reference_grid
  std::vector<std::uint32_t> original;  ///< place of each particle in the points given
  std::vector<std::uint32_t> component; ///< 0, 1, .. in the order of the particles
  std::uint32_t components = 0;
  Bonds bonds; ///< without weights
};

/// Whether two reference positions have no bond although they are near.
using Severed = std::function<bool(const Vector3& from, const Vector3& to)>;

/// Sorts by component, then z, y, x. `horizon` in metres. `severed`: bonds that are not made. Throws
/// Error(usage) for points that are not finite or that coincide once snapped, and for a horizon beyond what a
/// packed bond vector holds.
Arrangement arrange(const std::vector<Vector3>& points, double spacing, double horizon,
                    const Severed& severed = {});

/// The same without bonds, of points that are one component: of fluids.
Arrangement arrange_unbonded(const std::vector<Vector3>& points, double spacing);

/// The values of a body that the model keeps for each particle, in the arrangement's order.
struct BodyParticles {
  Arrangement arrangement; ///< with weights
  std::vector<Vector3> position, velocity;
  std::vector<double> volume, mass;
  std::vector<std::uint32_t> material;
  std::uint32_t first_id = 0; ///< id of the body's first point
};

/// Appends a body's particles to a model, under the law given; bodies of one law must follow each other.
/// Sets the body's `first` and `count`.
void append(Model& model, std::uint32_t body, Law law, BodyParticles&& particles);

/// Adds one body's report to the whole's; `before` and `added` count particles.
void merge(WeightReport& whole, const WeightReport& part, std::size_t before, std::size_t added);

} // namespace pliant
