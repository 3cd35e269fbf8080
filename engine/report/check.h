// What can be known of a scene before it runs: its bodies, its memory, how stiff a step is, and how long it
// will take.
#pragma once

#include "engine/device/device.h"
#include "engine/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace pliant {

struct CheckReport {
  struct Body {
    std::string name, material;
    std::size_t particles = 0;
    double mesh_volume = 0;     ///< m3, enclosed by its surface
    double lattice_volume = 0;  ///< m3, particles times the cube of the spacing, before they were rescaled
    double particle_volume = 0; ///< m3, sum of what the particles stand for
    double mass = 0;            ///< kg
    Vector3 low = Vector3::Zero(), high = Vector3::Zero(); ///< m, box of the particles at t = 0
  };
  std::string scene;
  std::vector<Body> bodies;
  std::size_t particles = 0, bonds = 0;
  double worst_weight_residual = 0,
         weights_over_5_percent = 0; ///< of the moment conditions; share of particles
  std::size_t host_bytes = 0;        ///< of the model, about
  std::size_t device_bytes = 0;
  double bytes_per_particle = 0, bytes_per_bond = 0;
  double time_step = 0, end = 0; ///< s; the step after it was fitted to the frames
  std::uint64_t steps = 0, frames = 0;
  std::string solver; ///< method, preconditioner, and why
  double stiffness_number = 0;
  double predicted_iterations = 0; ///< a step, before the cap
  unsigned iteration_cap = 0;
  double largest_move = 0;     ///< m in a step, of what moves at the start or is made to move
  std::string backend, device; ///< that the time was measured on
  double ms_per_iteration = 0;
  double seconds = 0; ///< estimate of the whole run, without pictures
  std::vector<std::string> warnings;
};

/// Assembles the scene, sets it up on a device and runs a few iterations for the estimate (about a second).
/// Throws what assembling and setting up throw.
CheckReport check_scene(Scene scene, Device& device);
std::string check_text(const CheckReport& report);
nlohmann::json check_json(const CheckReport& report);

} // namespace pliant
