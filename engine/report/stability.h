// The stiff and extreme sweep: which scenes stay finite and bounded, and which bodies come back, with each
// solver on each backend.
//
//   problem   a body from the scene in an extreme state or under an extreme setting; built through the
//   library,
//             since scene files with such states are refused
//   cell      a problem, solved by one method on one backend; judged at every step
//   apart     cells of methods that are no part of the product: tabled, but left out of the summary
#pragma once

#include "engine/model/model.h"
#include "engine/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace pliant {

/// Farther than so many body sizes from where its centre would be in free fall, a particle is lost.
inline constexpr double stability_reach = 10;
/// What a recovered body has at most left of root-mean-square bond strain, and at least of upright particles.
inline constexpr double stability_strain = 1e-2, stability_upright = 0.99;

/// What must hold at the end of a run, apart from finite and bounded.
enum class Wanted : std::uint8_t {
  nothing, ///< no time to come back, or nothing to come back to
  shape,   ///< the rest shape: see stability_strain
  fall,    ///< each particle where free fall has it, to 1e-5 of the way
  still,   ///< at most a hundredth of a spacing from where it was halfway
  stack    ///< two bodies on a floor, less than half a spacing in each other and in the floor
};

struct StabilitySetup {
  Scene scene;
  Model model;
  std::vector<Vector3> position, velocity; ///< at the start: m, world; m/s
  double size = 0;                         ///< m: the body's, which reach is counted in
  bool own_centre = false;                 ///< obstacles push it: reach is counted from its centre of mass
  Wanted wanted = Wanted::nothing;
  std::uint32_t upper_first = 0; ///< stack: first particle of the upper body
};

struct StabilityProblem {
  std::string name;
  double young = 0, poisson = 0, time_step = 0; ///< Pa, -, s
  unsigned steps = 0;
  unsigned iterations = 0; ///< a cap for each step
  bool map = false;        ///< of the map of Young's modulus and time step
  bool on_gl = false;      ///< also where GL is software and the sweep is not a full one
  /// May throw Error(usage): then the problem is refused, which counts as good.
  std::function<StabilitySetup()> build;
};

struct StabilityOptions {
  std::vector<std::string> methods = {"chebyshev", "newton", "auto"};
  std::vector<std::string> backends; ///< "openmp-float", "openmp-double", "gl:N"; empty: all that are usable
  std::string only;                  ///< problems whose name contains it
  std::size_t particles = 500;       ///< at most
  unsigned steps = 60;
  unsigned iterations = 150; ///< a cap for each step
  double minutes = 10;       ///< no cell begins after; 0: no limit
  unsigned jobs = 0;         ///< CPU cells at a time; 0: as many as there are processors
  bool full = false;         ///< the whole grid, on GL too, and 1e5 steps at rest
  /// Lines of progress.
  std::function<void(const std::string&)> say = [](const std::string&) {};
};

struct StabilityCell {
  std::string name;
  double young = 0, poisson = 0, time_step = 0;
  double stiffness_number = 0;
  std::string method, backend; ///< as in StabilityOptions
  std::string resolved;        ///< the method that "auto" stands for
  bool map = false;
  bool refused = false; ///< with the reason in `message`; then finite, bounded and recovered hold
  bool finite = true, bounded = true, recovered = true;
  bool recovery_wanted = false;
  double strain = 0, upright = 1; ///< at the end; see stability_strain
  double farthest = 0;            ///< body sizes
  double first_distance = 0;      ///< rms distance from the Newton reference after the first step, spacings
  double end_distance = 0;        ///< the same at the end
  double energy = 0;  ///< largest kinetic and elastic energy over that at the start; 0 where that is 0
  unsigned steps = 0; ///< taken
  std::uint64_t iterations = 0;      ///< of all steps
  unsigned restarts = 0, at_cap = 0; ///< of all steps; steps that ended at the cap
  double seconds = 0;
  std::string message; ///< what is wrong
  bool good() const { return finite && bounded && (recovered || !recovery_wanted); }
};

struct StabilityReport {
  std::string scene;
  std::size_t particles = 0;
  unsigned steps = 0, iterations = 0;
  std::vector<StabilityCell> cells;
  std::vector<StabilityCell> apart;
  std::vector<std::string> left_out; ///< backends that are not usable, cells that time was too short for
  double seconds = 0;
  std::size_t count(bool (*of)(const StabilityCell&)) const;
  std::size_t non_finite() const;
  std::size_t unbounded() const;
  std::size_t unrecovered() const;
  bool good() const { return non_finite() == 0 && unbounded() == 0; }
};

/// Problems for the scene's first body, in its material and with its solver's tolerance. Throws what
/// sampling the body does.
std::vector<StabilityProblem> stability_problems(const Scene& scene, const StabilityOptions& options);

/// Judges a run: positions after every step, in the model's order.
class StabilityWatch {
public:
  /// Of a run of so many steps; `setup` must outlive it.
  StabilityWatch(const StabilitySetup& setup, unsigned steps);
  /// After step `n`, counted from one, of `step` seconds each. Returns false where it is not finite.
  bool after(unsigned n, double step, const std::vector<Vector3>& positions);
  /// Fills finite, bounded, recovered, strain, upright, farthest and message.
  void judge(StabilityCell& cell) const;

private:
  Vector3 fallen(const Vector3& velocity, unsigned n, double step) const;
  std::string missed(const StabilityCell& cell) const;

  const StabilitySetup& setup_;
  unsigned steps_;
  Vector3 centre_ = Vector3::Zero(), velocity_ = Vector3::Zero(); ///< of mass, at the start
  std::vector<Vector3> middle_, last_;                            ///< positions halfway and now
  double step_ = 0, farthest_ = 0;
  unsigned taken_ = 0, lost_at_ = 0, not_finite_at_ = 0; ///< steps; 0: never
};

/// Throws Error(usage) for a method, backend or problem that there is not.
StabilityReport sweep_stability(const Scene& scene, const StabilityOptions& options);

std::string stability_text(const StabilityReport& report);
std::string stability_csv(const StabilityReport& report);
nlohmann::json stability_json(const StabilityReport& report);
/// stability.csv, stability.json, stability.svg and stability.png. Throws Error(input_output).
void write_stability(const StabilityReport& report, const std::filesystem::path& folder);

} // namespace pliant
