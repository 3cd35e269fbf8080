// Scenes to start from: short, commented, complete.
#include "engine/scene/scene_new.h"

#include "engine/core/error.h"
#include "engine/scene/scene_parse_findings.h"

namespace pliant {
namespace {

constexpr const char* drop =
    R"(# A soft ball falls on a box, and both on the floor. `pliant schema` lists every key; units are SI.
#   pliant check drop.toml
#   pliant run drop.toml --out out/drop
format = 1
name = "drop"

[simulation]
spacing = 0.02            # m, between particles: halve it for eight times as many
horizon = 1.87            # reach of a bond, in spacings
time_step = "1/60"        # s
end = 2.0                 # s
gravity = [0, -9.81, 0]   # m/s2

[solver]
tolerance = 1e-3          # relative residual at which a step is solved
iterations = 1000         # a cap; reaching it is reported

[contact]
friction = 0.3            # between particles of different bodies

[materials.rubber]
density = 1000            # kg/m3
young = 3e5               # Pa
poisson = 0.35            # 0 to 0.499
color = [0.80, 0.42, 0.25]

[[body]]
name = "box"
material = "rubber"
shape = { box = [0.5, 0.2, 0.5], at = [0, 0.3, 0] }

[[body]]
name = "ball"
material = "rubber"
shape = { sphere = 0.15, at = [0.1, 0.8, 0] }
velocity = [0, -1, 0]     # m/s
color = [0.25, 0.50, 0.78]
# For a mesh of your own (closed; OBJ, OFF, PLY or STL):
# shape = { mesh = "ball.obj", fit = 0.3, at = [0.1, 0.8, 0] }

[[boundary]]
name = "floor"
shape = { plane = [0, 1, 0], offset = 0 }
condition = "slip"        # or "no-slip"
friction = 0.5

[output]
fps = 30
fields = ["velocity", "strain"]

[render]
size = [1280, 720]
camera = { eye = [0.9, 0.8, 1.6], look = [0, 0.25, 0], fov = 40 }
)";

constexpr const char* beam =
    R"(# A beam, held at one end, bends under its weight and a load. `pliant schema` lists every key; units are SI.
#   pliant check beam.toml
#   pliant run beam.toml --out out/beam
#   pliant run beam.toml --set materials.rubber.young=1e7 --out out/stiff-beam
format = 1
name = "beam"

[simulation]
spacing = 0.02            # m, between particles
horizon = 1.87            # reach of a bond, in spacings
time_step = 0.004         # s
end = 2.0                 # s
gravity = [0, -9.81, 0]   # m/s2

[solver]
tolerance = 1e-3          # relative residual at which a step is solved

[materials.rubber]
density = 1000            # kg/m3
young = 1e6               # Pa
poisson = 0.25            # 0 to 0.499

[[body]]
name = "beam"
material = "rubber"
shape = { box = [0.6, 0.1, 0.1], at = [0.3, 0.5, 0] }

[[body.fixed]]            # the particles within stay where they are
region = { box = [0.08, 0.2, 0.2], at = [0, 0.5, 0] }

[[body.loaded]]           # the particles within share a force
region = { box = [0.08, 0.2, 0.2], at = [0.6, 0.5, 0] }
force = [0, 0, 2]         # N
end = 1.0                 # s; then it lets go

[output]
fps = 25
fields = ["displacement", "strain"]

[render]
camera = { eye = [0.3, 0.55, 1.4], look = [0.3, 0.42, 0], fov = 35 }
color = "strain"
)";

} // namespace

std::vector<std::pair<std::string, std::string>> new_scene_kinds() {
  return {{"drop", "a ball and a box fall on the floor"}, {"beam", "a beam held at one end, under a load"}};
}

std::string new_scene_text(std::string_view kind) {
  if (kind == "drop") return drop;
  if (kind == "beam") return beam;
  std::vector<std::string> known;
  for (const auto& entry : new_scene_kinds()) known.push_back(entry.first);
  throw Error(ExitCode::usage, "no kind of scene " + in_quotes(kind) + suggestion(kind, known));
}

} // namespace pliant
