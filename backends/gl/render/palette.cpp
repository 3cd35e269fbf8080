// The field's colours are built in CIE L*a*b* (D65), chroma lowered where sRGB cannot show it.
#include "backends/gl/render/palette.h"

#include <algorithm>
#include <cmath>

namespace pliant::gl {

namespace {

constexpr double pi = 3.14159265358979323846;

Vector3 lab_to_linear(double lightness, double chroma, double hue) {
  const auto inverse = [](double t) { return t > 6.0 / 29 ? t * t * t : 3 * 36.0 / 841 * (t - 4.0 / 29); };
  const double y = (lightness + 16) / 116, a = chroma * std::cos(hue), b = chroma * std::sin(hue);
  const double X = 0.95047 * inverse(y + a / 500), Y = inverse(y), Z = 1.08883 * inverse(y - b / 200);
  return {3.2406 * X - 1.5372 * Y - 0.4986 * Z, -0.9689 * X + 1.8758 * Y + 0.0415 * Z,
          0.0557 * X - 0.2040 * Y + 1.0570 * Z};
}

Colour field_colour(double share) {
  const double lightness = 16 + 75 * share;
  const double hue = (312 - 212 * std::pow(share, 1.05)) * pi / 180; // violet 312, teal near 200, yellow 100
  double chroma = 42 + 12 * std::cos(2 * pi * share) + 24 * share * share * share;
  Vector3 linear = lab_to_linear(lightness, chroma, hue);
  while ((linear.minCoeff() < 0 || linear.maxCoeff() > 1) && chroma > 0) {
    chroma -= 0.25;
    linear = lab_to_linear(lightness, chroma, hue);
  }
  Colour colour{};
  for (int c = 0; c < 3; ++c)
    colour[c] = static_cast<std::uint8_t>(std::lround(255 * to_encoded(std::clamp(linear[c], 0.0, 1.0))));
  return colour;
}

} // namespace

double to_linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double to_encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

Vector3 to_linear(const Vector3& encoded) {
  return {to_linear(encoded.x()), to_linear(encoded.y()), to_linear(encoded.z())};
}

const std::array<Colour, 256>& field_colours() {
  static const std::array<Colour, 256> colours = [] {
    std::array<Colour, 256> made{};
    for (int i = 0; i < 256; ++i) made[i] = field_colour(i / 255.0);
    return made;
  }();
  return colours;
}

std::vector<Vector3> body_colours(const Scene& scene, const Model& model) {
  const std::array<Vector3, 6> quiet{Vector3(0.80, 0.42, 0.28), Vector3(0.24, 0.52, 0.62),
                                     Vector3(0.86, 0.66, 0.30), Vector3(0.45, 0.58, 0.36),
                                     Vector3(0.56, 0.40, 0.58), Vector3(0.74, 0.70, 0.64)};
  std::vector<Vector3> colours;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    bool named = i >= scene.bodies.size();
    if (!named) {
      const Material* material = scene.material(scene.bodies[i].material);
      named = scene.bodies[i].color.has_value() || (material && material->color_given);
    }
    colours.push_back(to_linear(named ? model.bodies[i].color : quiet[i % quiet.size()]));
  }
  return colours;
}

} // namespace pliant::gl
