// Do the backends agree? A run in double on the CPU is the master; from its states every other device runs a
// stretch with the same number of iterations in each step, and the fields at the end are compared. Where the
// scene names a method with a line search each step is solved instead: cut off on its way, a search that took
// or refused one step by a rounding is somewhere else, and both are right.
//
//   master  0 ----> 10 ----> 20 ----> ... ----> 100      openmp, double
//           |        |        |
//           +--> ?   +--> ?   +--> ?                      each other device: judged
//           +-------------------------------------> ?     without restarts: reported only, as differences
//                                                         grow with time in any motion that is not damped
//
// Where particles of a fluid part company, a difference may grow fivefold from step to step. How it does is
// measured: the master repeats each stretch from a start that is off by a rounding of a float, and the
// stretch is judged at its last step at which that has made no more than a tenth of the limit; at its first
// if there is none. Beyond, nobody can tell a wrong term from a right one that is rounded otherwise. The
// limit stays.
#pragma once

#include "engine/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <string>
#include <vector>

namespace pliant {

/// Largest difference of a field after a stretch, relative to its scale. Float rounding of a few hundred
/// operations on numbers the size of the body leaves it ten times below; a wrong term shows up far above.
inline constexpr double verify_limit = 1e-4;
/// What one rounding of the start may grow to, in double, where a stretch is judged. A float rounds each
/// operation besides: ten times this is left to it.
inline constexpr double verify_growth = verify_limit / 10;
/// Relative residual of steps that are solved: what a float reaches, or it ends at its floor.
inline constexpr double verify_tolerance = 1e-5;
/// Iterations of a step of viscoelastic matter at the least. Its sweeps are restarted where contacts come or
/// go: a step that is cut off on the way is somewhere else after a restart that falls one iteration later.
/// Solved, it is not.
inline constexpr unsigned verify_bonded = 200;

struct VerifyOptions {
  unsigned steps = 100; ///< of the master
  /// Length of a stretch, steps; 0: 10, of fluids 5.
  unsigned every = 0;
  unsigned iterations = 20; ///< of each step, whatever its residual; methods with a line search solve it
  bool kernels = true;      ///< run one step on each GL device with every kernel replayed on the CPU
  /// Lines of progress.
  std::function<void(const std::string&)> say = [](const std::string&) {};
};

/// What `every` stands for.
unsigned stretch_length(const VerifyOptions& options, const Scene& scene);
/// Of a step of sweeps.
unsigned verify_iterations(const VerifyOptions& options, const Scene& scene);
/// How many of its steps a stretch is judged after; `growth`: what a rounding of its start has made after
/// each.
unsigned judged_steps(const std::vector<double>& growth);

struct FieldDifference {
  std::string name;
  double max_relative = 0;    ///< of all particles, and of all stretches
  double median_relative = 0; ///< of the particles; the largest of all stretches
};

struct VerifyReport {
  struct Pair {
    std::string a, b;
    unsigned steps = 0; ///< of a stretch
    unsigned stretches = 0;
    std::vector<FieldDifference> fields; ///< position by the body's size; velocity by the largest speed
    bool within() const;
  };
  struct Hashes {
    std::string device;
    std::string first, second;
    bool identical() const { return first == second; }
  };
  struct Kernels {
    std::string device;
    std::size_t compared = 0;
    std::size_t ties = 0; ///< results that fell to the other side of a tie: see replay.h
    std::string mismatch; ///< empty: none
  };
  std::string scene;
  std::size_t particles = 0, bonds = 0;
  unsigned iterations = 0;    ///< of a step; 0: each is solved
  std::vector<Pair> pairs;    ///< judged
  std::vector<Pair> unbroken; ///< reported
  std::vector<Hashes> run_to_run, threads;
  std::vector<Kernels> kernels;
  struct Stretches {
    unsigned count = 0, shortened = 0; ///< shortened: judged before their end
    unsigned shortest = 0;             ///< steps
    double growth = 0; ///< what a rounding of the start made at the end of a stretch, in double: the most
  } stretches;         ///< of fluids
  std::vector<std::string> skipped; ///< devices that are not usable, and why
  bool run_to_run_identical() const;
  bool threads_identical() const;
  bool good() const;
};

/// Throws Error(usage) where `steps` is no multiple of `every`, and what assembling and setting up throw.
VerifyReport verify_scene(Scene scene, const VerifyOptions& options);
std::string verify_text(const VerifyReport& report);
nlohmann::json verify_json(const VerifyReport& report);

} // namespace pliant
