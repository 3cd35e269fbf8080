// Everything about a scene that needs no run, and the time of a few iterations.
#include "engine/report/check.h"

#include "engine/plan/expected_iterations.h"
#include "engine/solver/simulation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pliant {

namespace {

constexpr unsigned trial_iterations = 16;
constexpr unsigned fewest_trials = 3, most_trials = 8; ///< steps
constexpr double trial_seconds = 1;                    ///< no more than the fewest after this

double enclosed_volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return sum / 6;
}

CheckReport::Body describe(const Scene& scene, const Model& model, const BodyModel& body) {
  CheckReport::Body row;
  row.name = body.name;
  row.particles = body.count;
  row.low = Vector3::Constant(1e300), row.high = -row.low;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
    row.particle_volume += model.volume[i];
    row.mass += model.mass[i];
    row.low = row.low.cwiseMin(model.position[i]);
    row.high = row.high.cwiseMax(model.position[i]);
  }
  if (body.count > 0) row.material = typed_material(scene, model, body.first).name;
  row.lattice_volume = static_cast<double>(body.count) * std::pow(model.spacing, 2) *
                       (body.thickness > 0 ? body.thickness : model.spacing);
  row.mesh_volume =
      body.surface && !(body.thickness > 0) ? enclosed_volume(*body.surface) : row.particle_volume;
  return row;
}

/// Fastest point of a rigid motion among those at a distance of at most `reach` from its axis, m/s.
double speed_of(const Motion& motion, double reach) {
  return motion.velocity.norm() + std::abs(motion.rate) * reach;
}

double distance_from_axis(const Motion& motion, const Vector3& point) {
  return (point - motion.about).cross(motion.axis).norm();
}

/// Farthest that anything is known to move in one step, m: initial velocities, a step of free fall, what is
/// moved.
double largest_move(const Scene& scene, const Model& model, double time_step) {
  double speed = 0;
  for (const Vector3& v : model.velocity) speed = std::max(speed, v.norm());
  speed += scene.simulation.gravity.norm() * time_step;
  for (const Held& held : model.held) {
    const Motion& motion = model.motions[held.motion];
    speed = std::max(speed, speed_of(motion, distance_from_axis(motion, model.position[held.particle])));
  }
  for (const Boundary& boundary : scene.boundaries) {
    const double extent =
        std::max({boundary.shape.size.norm() / 2, boundary.shape.radius + boundary.shape.tube,
                  boundary.shape.height / 2, boundary.shape.fit.value_or(0) / 2});
    const bool plane = boundary.shape.kind == Shape::Kind::plane;
    speed = std::max(speed,
                     speed_of(boundary.motion,
                              plane ? 0 : distance_from_axis(boundary.motion, boundary.shape.at) + extent));
  }
  return speed * time_step;
}

std::size_t host_bytes(const Model& model) {
  const std::size_t particle = 3 * sizeof(Vector3) + 2 * sizeof(double) + 4 * sizeof(std::uint32_t);
  const std::size_t bond = 2 * sizeof(std::uint32_t) + sizeof(double);
  return model.count() * particle + model.bonds.count() * bond;
}

/// ms of one iteration, from steps of a fixed number of them; the first step, which may compile, is left out.
double measure_iteration(Simulation& simulation, Device& device) {
  using Clock = std::chrono::steady_clock;
  const auto step = [&] {
    const Clock::time_point start = Clock::now();
    simulation.step();
    device.finish();
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  double spent = step(), best = spent;
  for (unsigned k = 1; k < most_trials && (k < fewest_trials || spent < trial_seconds); ++k) {
    const double took = step();
    best = k == 1 ? took : std::min(best, took);
    spent += took;
  }
  return 1000 * best / (trial_iterations + 1); // a step evaluates the force once more than it iterates
}

void warn(CheckReport& report, const Scene& scene, const Model& model) {
  report.warnings = model.warnings;
  const double spacing = model.spacing;
  if (report.iteration_cap < 0.1 * report.predicted_iterations)
    report.warnings.push_back(fmt::format(
        "solver.iterations = {} is less than a tenth of the {:.0f} that a step is expected to need: bodies "
        "will look softer than they are; raise it, shorten the time step, or use larger particles",
        report.iteration_cap, report.predicted_iterations));
  if (report.largest_move > spacing)
    report.warnings.push_back(
        fmt::format("something moves {:.3g} m in a step, {:.1f} spacings: contacts may be missed; a "
                    "time step of {:.2g} s would do",
                    report.largest_move, report.largest_move / spacing,
                    report.time_step * spacing / report.largest_move));
  if (report.weights_over_5_percent > 0.05)
    report.warnings.push_back(
        fmt::format("{:.1f} % of the particles have too few neighbours for their material's "
                    "constants to be met within 5 %: a smaller spacing resolves thin parts better",
                    100 * report.weights_over_5_percent));
  for (const CheckReport::Body& body : report.bodies)
    if (std::abs(body.lattice_volume - body.mesh_volume) > 0.05 * body.mesh_volume)
      report.warnings.push_back(
          fmt::format("body '{}': its particles fill {:.3g} m3 of {:.3g} m3 (they are rescaled): a "
                      "smaller spacing follows the shape better",
                      body.name, body.lattice_volume, body.mesh_volume));
  if (std::abs(report.time_step / scene.simulation.time_step - 1) > 1e-9)
    report.warnings.push_back(
        fmt::format("the time step is shortened from {:.6g} s to {:.6g} s, so that a frame is a whole "
                    "number of steps",
                    scene.simulation.time_step, report.time_step));
}

std::string duration_text(double seconds) {
  if (seconds < 1) return "less than a second";
  if (seconds < 120) return fmt::format("about {:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("about {:.0f} min", seconds / 60);
  return fmt::format("about {:.1f} h", seconds / 3600);
}

std::string size_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.1f} MB", bytes / 1e6) : fmt::format("{:.2f} GB", bytes / 1e9);
}

} // namespace

CheckReport check_scene(Scene scene, Device& device) {
  CheckReport report;
  report.scene = scene.name;
  const Model model = assemble(scene);
  for (const BodyModel& body : model.bodies) report.bodies.push_back(describe(scene, model, body));
  report.particles = model.count();
  report.bonds = model.bonds.count();
  report.worst_weight_residual = model.weight_report.worst_residual;
  report.weights_over_5_percent = model.weight_report.share_over_5_percent;
  report.host_bytes = host_bytes(model);
  report.iteration_cap = scene.solver.iterations;
  report.end = scene.simulation.end;

  scene.solver.iterations = trial_iterations;
  scene.solver.fixed_iterations = true;
  PlanRequest request;
  request.frames = true;
  request.divergence = true;
  request.fields = scene.output.fields;
  Simulation simulation(device, scene, model, request);
  const Precision precision = device.info().precision;
  report.device_bytes = simulation.plan().bytes(precision);
  report.bytes_per_particle = simulation.plan().bytes_per_particle(precision);
  report.bytes_per_bond = simulation.plan().bytes_per_bond(precision);
  report.time_step = simulation.time_step();
  report.steps = static_cast<std::uint64_t>(std::ceil(report.end / report.time_step * (1 - 1e-9)));
  report.frames = static_cast<std::uint64_t>(std::floor(report.end * scene.output.fps * (1 + 1e-9)));
  report.stiffness_number = simulation.stiffness_number();
  const Method& method = simulation.plan().method;
  report.solver =
      method.name + (method.preconditioner.empty() ? "" : ", " + method.preconditioner + " preconditioner");
  if (!method.reason.empty()) report.solver += " (auto: " + method.reason + ")";
  // An energy goes with the square of a residual.
  const double tolerance =
      method.energy_tolerance > 0 ? std::sqrt(method.energy_tolerance) : scene.solver.tolerance;
  report.predicted_iterations = expected_iterations(method, tolerance);
  report.largest_move = largest_move(scene, model, report.time_step);
  report.backend = device.info().backend;
  report.device = device.info().name;
  report.ms_per_iteration = measure_iteration(simulation, device);
  const double iterations =
      std::min(report.predicted_iterations, static_cast<double>(report.iteration_cap)) + 1;
  report.seconds = 1e-3 * report.ms_per_iteration * iterations * static_cast<double>(report.steps);
  if (simulation.plan().fluid) {
    report.solver = "position-based fluid";
    report.predicted_iterations = report.iteration_cap = scene.fluid.density_iterations;
    const double step = report.ms_per_iteration * (trial_iterations + 1);
    report.ms_per_iteration = step / scene.fluid.density_iterations;
    report.seconds = 1e-3 * step * static_cast<double>(report.steps);
  }
  warn(report, scene, model);
  return report;
}

std::string check_text(const CheckReport& r) {
  std::string text =
      fmt::format("scene {}: {} particles, {} bonds ({:.1f} a particle)\n\n", r.scene, r.particles, r.bonds,
                  r.particles ? double(r.bonds) / double(r.particles) : 0);
  for (const CheckReport::Body& body : r.bodies) {
    const Vector3 size = body.high - body.low;
    text += fmt::format("  body {}: {} particles of {}; {:.4g} kg; box {:.3g} x {:.3g} x {:.3g} m\n",
                        body.name, body.particles, body.material, body.mass, size.x(), size.y(), size.z());
    text += fmt::format(
        "    volume {:.5g} m3 of the shape, {:.5g} m3 of the lattice in it ({:+.1f} %), {:.5g} m3 of the "
        "particles\n",
        body.mesh_volume, body.lattice_volume,
        100 * (body.lattice_volume / std::max(body.mesh_volume, 1e-300) - 1), body.particle_volume);
  }
  text +=
      fmt::format("  weights: moments met within {:.1g}; {:.1f} % of the particles off by more than 5 %\n",
                  r.worst_weight_residual, 100 * r.weights_over_5_percent);
  text +=
      fmt::format("  memory: {} on the device ({:.0f} bytes a particle, {:.1f} a bond), {} of the model\n",
                  size_text(double(r.device_bytes)), r.bytes_per_particle, r.bytes_per_bond,
                  size_text(double(r.host_bytes)));
  text += fmt::format("  time: {} steps of {:.5g} s to {:.4g} s, {} frames\n", r.steps, r.time_step, r.end,
                      r.frames);
  text += fmt::format("  solver: {}\n", r.solver);
  text += fmt::format("  stiffness number {:.3g}: a step is expected to need {:.0f} iterations (cap {})\n",
                      r.stiffness_number, r.predicted_iterations, r.iteration_cap);
  text += fmt::format("  on {}, {}: {:.3g} ms an iteration; the whole run {}, without pictures\n", r.backend,
                      r.device, r.ms_per_iteration, duration_text(r.seconds));
  for (const std::string& warning : r.warnings) text += fmt::format("\nwarning: {}\n", warning);
  if (r.warnings.empty()) text += "\nThe scene is sound.\n";
  return text;
}

nlohmann::json check_json(const CheckReport& r) {
  using nlohmann::json;
  const auto vector = [](const Vector3& v) { return json::array({v.x(), v.y(), v.z()}); };
  json bodies = json::array();
  for (const CheckReport::Body& body : r.bodies)
    bodies.push_back({{"name", body.name},
                      {"material", body.material},
                      {"particles", body.particles},
                      {"mass", body.mass},
                      {"mesh_volume", body.mesh_volume},
                      {"lattice_volume", body.lattice_volume},
                      {"particle_volume", body.particle_volume},
                      {"low", vector(body.low)},
                      {"high", vector(body.high)}});
  return {{"scene", r.scene},
          {"bodies", bodies},
          {"particles", r.particles},
          {"bonds", r.bonds},
          {"weights",
           {{"worst_residual", r.worst_weight_residual}, {"share_over_5_percent", r.weights_over_5_percent}}},
          {"memory",
           {{"device_bytes", r.device_bytes},
            {"host_bytes", r.host_bytes},
            {"bytes_per_particle", r.bytes_per_particle},
            {"bytes_per_bond", r.bytes_per_bond}}},
          {"time_step", r.time_step},
          {"end", r.end},
          {"steps", r.steps},
          {"frames", r.frames},
          {"solver", r.solver},
          {"stiffness_number", r.stiffness_number},
          {"predicted_iterations", r.predicted_iterations},
          {"iteration_cap", r.iteration_cap},
          {"largest_move", r.largest_move},
          {"estimate",
           {{"backend", r.backend},
            {"device", r.device},
            {"ms_per_iteration", r.ms_per_iteration},
            {"seconds", r.seconds}}},
          {"warnings", r.warnings}};
}

} // namespace pliant
