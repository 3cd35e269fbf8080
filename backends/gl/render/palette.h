// Colours: of fields, of bodies that were given none; from sRGB to light and back.
#pragma once

#include "engine/model/model.h"
#include "engine/render/image.h"

#include <Eigen/Core>

#include <array>

namespace pliant::gl {

/// Linear light of an sRGB value, each 0 to 1, and back.
double to_linear(double encoded);
double to_encoded(double linear);
Vector3 to_linear(const Vector3& encoded);

/// A field's colours from low to high, sRGB: lightness (CIE L*) rises evenly from 16 to 91 while the hue
/// turns from violet over teal to yellow, so that equal steps of the field look equal, in grey too.
const std::array<Colour, 256>& field_colours();

/// Linear colour of each body: its own or its material's where the scene names one, else of a set of quiet
/// colours.
std::vector<Vector3> body_colours(const Scene& scene, const Model& model);

} // namespace pliant::gl
