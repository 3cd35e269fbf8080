// Error against run time within one step: every method on every backend solves the same step from the same
// state and the same first guess, and is compared with a reference that a second start confirms.
//
//   own solver, double   0 ----> state ---.---> reference: newton, double, to the last bit; twice
//                                          |
//                                          +---> newton    double  .  .  .  .
//                                          +---> newton    gl      .  .  .  .    each judged in double,
//                                          outside
//                                          +---> chebyshev double  .  .  .  .    the clock
//
// Energy error: He, Wang and Wu (2018), Eq. 25. Residual: their Eq. 12 of 2017 in the D^-1 norm.
#pragma once

#include "engine/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

struct ConvergeOptions {
  std::optional<unsigned> at;        ///< steps before the one that is watched; else the hardest of the first
  double seconds = 20;               ///< of one series
  double total_seconds = 510;        ///< of all series together: those that remain share what is left
  std::vector<std::string> only;     ///< methods ("newton", "newton+multilevel"); empty: all
  std::vector<std::string> backends; ///< "openmp", "gl", "gl:N"; empty: all that are usable
  unsigned threads = 0;              ///< of the openmp backend; 0: as many as there are processors
  /// Lines of progress.
  std::function<void(const std::string&)> say = [](const std::string&) {};
};

/// Where a solve would end after so many iterations.
struct ConvergePoint {
  unsigned iteration = 0;                    ///< force evaluations and products of the derivative
  double ms = 0;                             ///< since the step began; median of the passes
  double residual = 0;                       ///< of the start's
  double energy_error = 0;                   ///< of the start's; not a number where forces have no potential
  double position_rms = 0, position_max = 0; ///< spacings, to the reference
};

struct ConvergeSeries {
  std::string method, preconditioner; ///< preconditioner: empty where the method has no choice
  std::string backend, device, precision;
  bool software = false; ///< a GL that runs on the CPU
  double setup_ms = 0;   ///< buffers, kernels, coarse levels, factorisation: once a run
  unsigned passes = 1;   ///< timed
  std::string end;       ///< why it ended
  std::vector<ConvergePoint> points;
  std::string variant() const; ///< "newton+multilevel"
  std::string place() const;   ///< "openmp double"
};

/// The converged step.
struct ConvergeReference {
  std::string method;
  unsigned iterations = 0;
  double seconds = 0;
  double residual = 0;                       ///< relative to the first guess's
  std::string second_start;                  ///< what it was
  double agree_rms = 0, agree_max = 0;       ///< spacings, between the ends of both starts
  double potential = 0, first_potential = 0; ///< J; not a number without
  double energy_floor = 0;                   ///< energy error that rounding of the potential alone makes
  double first_rms = 0, first_max = 0;       ///< spacings: position error of the first guess
  /// The two starts agree to 1e-6 spacings, what series are followed to.
  bool confirmed() const { return agree_max < 1e-6; }
};

struct ConvergeReport {
  std::string scene, processor, build;
  unsigned threads = 1;
  std::size_t particles = 0, bonds = 0;
  double stiffness_number = 0, spacing = 0, time_step = 0; ///< -, m, s
  std::uint64_t step = 0;                                  ///< steps taken before the one watched
  double residual_at_start = 0;                            ///< sqrt(N m)
  ConvergeReference reference;
  std::vector<ConvergeSeries> series;
  std::vector<std::string> left_out; ///< what did not run, and why
  double seconds = 0;                ///< of the whole
};

/// Throws Error(usage): a method or backend of no such name, a scene without particles, a step past the
/// scene's end; Error(diverged): the scene's own solver lost the state on the way.
ConvergeReport converge_step(const Scene& scene, const ConvergeOptions& options);

inline constexpr std::array<double, 6> converge_errors{1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
inline constexpr std::array<double, 6> converge_energy_errors{1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8};
/// ms from which on this error stays at or below `limit`; nothing where that never comes.
std::optional<double> time_to(const ConvergeSeries& series, double ConvergePoint::*error, double limit);

std::string converge_text(const ConvergeReport& report);
nlohmann::json converge_json(const ConvergeReport& report);
std::string converge_csv(const ConvergeReport& report);
/// converge.csv, .json, .svg, .png (position error) and converge-residual.svg, .png; with
/// converge-energy and, against iterations, converge-energy-iterations where there is a potential. Returns
/// the paths. Throws Error(input_output).
std::vector<std::filesystem::path> write_converge(const ConvergeReport& report,
                                                  const std::filesystem::path& folder);

} // namespace pliant
