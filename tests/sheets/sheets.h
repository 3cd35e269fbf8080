// Scenes of sheets and planes that the tests share.
#pragma once

#include "engine/scene/scene_parse.h"
#include "tests/support/bodies.h"

#include <fmt/format.h>

namespace pliant::test {

struct FlatScene {
  std::string law = "corotated";
  double poisson = 0.3, width = 3, height = 0.7, step = 0.05;
  std::string simulation = "", body = "", shape = "", rest = ""; ///< more lines
  std::string text() const {
    return fmt::format("[simulation]\nspacing = 0.1\ngravity = [0, 0, 0]\ntime_step = {}\n{}\n"
                       "[solver]\ntolerance = 1e-6\n{}\n"
                       "[materials.cloth]\nlaw = \"{}\"\nyoung = 2e5\npoisson = {}\n"
                       "[[body]]\nmaterial = \"cloth\"\nshape = {{ sheet = [{}, {}]{} }}\n{}\n",
                       step, simulation, rest, law, poisson, width, height, shape, body);
  }
  Scene scene() const {
    Scene made = parse_scene(text(), "flat.toml");
    made.output.fps = 1 / step;
    return made;
  }
};

/// A sheet 4 mm thick.
inline FlatScene sheet_scene(const std::string& law = "corotated", double poisson = 0.3) {
  FlatScene made;
  made.law = law;
  made.poisson = poisson;
  made.body = "thickness = 0.004";
  return made;
}
/// A plane scene one metre deep.
inline FlatScene plane_scene(const std::string& plane, const std::string& law = "corotated",
                             double poisson = 0.3) {
  FlatScene made;
  made.law = law;
  made.poisson = poisson;
  made.simulation = "dimension = 2\nplane = \"" + plane + "\"";
  return made;
}

/// Positions in the axes of the body, relative to its origin.
inline Points own_positions(const Model& model, const Points& world) {
  Points own;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const BodyModel& body = model.bodies[model.body[i]];
    own.push_back(body.axes.transpose() * (world[i] - body.origin));
  }
  return own;
}

} // namespace pliant::test
