// A simulation: a model on a device, advanced step by step. The order of kernels is in step.cpp.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/plan.h"

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

class Contacts;
class Elasticity;
class Failure;
class Fluid;
class GlobalStep;
class PlasticFlow;
class FrameOutput;
struct SavedState;
struct SimulationState;

/// stalled: a line search found no descent that the precision can tell.
enum class StopReason : std::uint8_t { none, tolerance, floor, cap, stalled };

/// One step's row.
struct StepStatistics {
  std::uint64_t step = 0;
  double time = 0;           ///< s, at the end of the step
  unsigned iterations = 0;   ///< accelerated Jacobi iterations that led to the result
  double residual = 0;       ///< of Eq. 12 in the D^-1 norm, relative to the start of the solve
  double first_residual = 0; ///< sqrt(N m)
  double last_residual = 0;  ///< of the result, sqrt(N m)
  double floor = 0;          ///< what the precision can reach, sqrt(N m)
  unsigned restarts = 0;     ///< of the guard
  StopReason reason = StopReason::none;
  double kinetic_energy = 0, elastic_energy = 0; ///< J
  Vector3 momentum = Vector3::Zero();            ///< kg m/s
  double largest_speed = 0;                      ///< m/s
  double largest_displacement = 0;               ///< m, in one step
  std::size_t not_finite = 0;                    ///< particles
  std::size_t broken_bonds = 0;                  ///< so far
  double fracture_energy = 0;                    ///< J, so far: what broken bonds held when they broke
  std::size_t yielding = 0;                      ///< particles that flowed in the step's last return
  double plastic_work = 0;                       ///< J, so far: what plastic flow took
  double plastic_strain = 0;                     ///< largest equivalent plastic strain so far
  double plastic_volume = 0;                     ///< m3, so far: gained at the apex of the yield surface
  unsigned plastic_rounds = 0;                   ///< solves of the step, each followed by a return
  double yield_excess = 0; ///< largest share of its strain that a particle lost in the step's last return
  // Of a line search on a potential.
  double energy_error = 0;   ///< estimated, of Eq. 25 (Xu et al. 2018); 1 where nothing asked for it
  unsigned energy_rises = 0; ///< iterates taken though the potential rose by more than the precision can tell
  // Of fluids.
  double density_error = 0;         ///< mean |C| of particles inside the fluid
  double largest_density_error = 0; ///< largest C
  double density_slope = 0;         ///< sum of |grad rho|^2, (kg/m^(d+1))^2
  unsigned viscosity_iterations = 0;
  double viscosity_residual = 0;     ///< relative
  double unevenness = 0;             ///< mean (support |grad rho| / rho)^2 inside, before the last sweep
  std::size_t removed = 0;           ///< particles that left the domain so far
  std::size_t emitted = 0, sunk = 0; ///< particles of fluids so far, where there are emitters or sinks
  std::size_t present = 0;           ///< of fluids, now
  std::size_t neighbours_dropped = 0, lists_full = 0; ///< in this step: neighbours without room in a list
};

/// Everything that a later step depends on, in double and world coordinates, in the model's order.
struct Snapshot {
  std::uint64_t step = 0;
  std::vector<Vector3> position, velocity;              ///< m, m/s
  std::vector<double> felt_gravity;                     ///< 0 to 1
  std::vector<Vector3> earlier_velocity, earlier_shift; ///< BDF2; else empty
  std::vector<Real4<double>> rotation;                  ///< corotated law; else empty
  std::vector<double> rest;                             ///< plasticity, as on the device; else empty
  std::vector<Real4<double>> flow, diagonal;            ///< with it
  std::vector<double> mass;                             ///< fluids: kg, 0 of what was removed; else empty
  struct FluidBonds {
    std::vector<std::uint32_t> near_count, near, near_place_of;
    std::vector<double> near_rest;
    std::vector<Real4<double>> fluid_flow;
  } bonds;                                        ///< of fluids, as on the device; else empty
  std::vector<std::uint32_t> emitter_count, sunk; ///< with it, where there are emitters and sinks
};

class Simulation {
public:
  /// Compiles and allocates what the plan lists. `scene` and `model` must outlive the simulation.
  Simulation(Device& device, const Scene& scene, const Model& model, const PlanRequest& request = {});
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Advances by one time step. Reads no state back; it only watches, late, whether the solve has ended.
  void step();

  /// A step in parts, for tools that watch the solve; step() is these. iterate() returns true once the solve
  /// has ended, by its own criterion or by the cap. `look`: judge this iterate too where the method would not
  /// yet, so that iterate_positions() is up to date.
  void begin_solving();
  bool iterate(bool look = false);
  void end_solving();
  /// m, world: where the step would end now. Between begin_solving() and end_solving().
  std::vector<Vector3> iterate_positions();
  /// Phi of Eq. 13 at world positions, J: inertia, elasticity and contacts without friction. After
  /// begin_solving(), which fixes y*; the solve cannot go on afterwards.
  double potential(const std::vector<Vector3>& positions);
  /// That, and the residual of Eq. 12 there in the D^-1 norm, sqrt(N m). The potential is not a number where
  /// the plan has no energies.
  struct Evaluation {
    double potential = 0, residual = 0;
  };
  Evaluation evaluate(const std::vector<Vector3>& positions);
  /// Another first guess, m, world: right after begin_solving(). Held particles stay where they are told to
  /// be.
  void start_from(const std::vector<Vector3>& positions);

  const Plan& plan() const { return plan_; }
  Device& device() { return device_; }
  double time() const { return static_cast<double>(step_) * time_step_; }
  double time_step() const { return time_step_; }
  std::uint64_t steps() const { return step_; }
  /// eta = h^2 max K_i / m_i: how stiff a step is.
  double stiffness_number() const { return stiffness_number_; }

  /// Rows of the steps so far that have arrived; waits for all of them if told to.
  std::vector<StepStatistics> take_statistics(bool wait = true);
  void measure(bool on);

  std::vector<Vector3> positions();  ///< m, world
  std::vector<Vector3> velocities(); ///< m/s
  Snapshot snapshot();
  void restore(const Snapshot& state);
  /// The state as the device stores it: loaded into a simulation of the same scene, build and device, the
  /// steps that follow are the same bit for bit. See saved_state.h.
  SavedState save();
  /// Throws Error(internal) for a state of other buffers.
  void load(const SavedState& state);
  /// Keeps the state on the device, and goes back to it. Plan: divergence.
  void keep();
  void rewind();
  /// One time step in `parts` equal ones of implicit Euler.
  void step_divided(unsigned parts);
  /// Internal elastic forces at the given world positions, N; for tests and tools. Leaves the state as it
  /// was.
  std::vector<Vector3> elastic_forces(const std::vector<Vector3>& positions);
  double elastic_energy(const std::vector<Vector3>& positions);
  /// Of fluids; null without.
  const Fluid* fluid() const { return fluid_.get(); }
  /// Contacts of the last step that found no room in their lists: they did not act. Waits for the device.
  std::uint32_t contacts_dropped();
  /// 1 less the share of its bonds' weights that is left to each particle; zero without failure.
  std::vector<double> damage();
  /// Equivalent plastic strain of every particle; zero without plasticity.
  std::vector<double> plastic_strain();
  /// FNV-1a of final positions and velocities as the device stores them, by id.
  std::string hash();

  /// Fills the frame's buffers (plan: frames); null when the plan has none.
  FrameOutput* frame();

private:
  friend class FrameOutput;

  void allocate();
  void upload(const SlicedBonds& bonds);
  void begin_step();
  void choose_step(double step);
  void gather_held(double time);
  void begin_solve();
  bool solve_ended();
  bool solve_again();
  void start_solver();
  void restore_momentum();
  void advance();
  void advance_fluid();
  void rebase();
  BufferStorage* persistent(const std::string& name) const;
  void write_statistics();
  StepStatistics row(std::span<const std::byte> bytes, std::uint64_t step) const;
  void load_displacement(const std::vector<Vector3>& positions);

  Device& device_;
  const Scene& scene_;
  const Model& model_;
  Plan plan_;
  Chunks chunks_;
  std::unique_ptr<SimulationState> state_;
  std::unique_ptr<Elasticity> elasticity_;
  std::unique_ptr<Failure> failure_;
  std::unique_ptr<PlasticFlow> plastic_;
  std::unique_ptr<Fluid> fluid_; ///< then there is no elasticity, nor a global step
  std::unique_ptr<Contacts> contacts_;
  std::unique_ptr<GlobalStep> global_step_;
  std::unique_ptr<FrameOutput> frame_;
  Vector3 scene_origin_ = Vector3::Zero(); ///< world coordinates on the device are relative to it
  double time_step_ = 0, solve_step_ = 0;  ///< h, and (2/3) h where BDF2
  std::vector<Real4<double>> loaded_;      ///< forces on the device, N
  std::uint32_t held_count_ = 0;           ///< particles held in this step
  double stiffness_number_ = 0, floor_ = 0, rounding_ = 0;
  unsigned iteration_ = 0;                               ///< of the solve
  unsigned plastic_rounds_ = 0, earlier_iterations_ = 0; ///< of the step: solves, iterations but the last's
  bool flowed_ = false;                                  ///< after the last of them
  std::uint64_t step_ = 0;
  bool first_of_bdf2_ = true;     ///< the step before is missing
  unsigned part_ = 0, parts_ = 1; ///< of a divided step
  std::uint64_t kept_step_ = 0;
  bool kept_first_of_bdf2_ = true;
  struct Pending {
    std::uint64_t step = 0;
    std::unique_ptr<Readback> readback, fracture, plastic, fluid, forces, bonds;
    unsigned plastic_rounds = 0, earlier_iterations = 0;
    std::uint64_t emitted = 0;
    std::unique_ptr<Readback> sunk = nullptr;
  };
  std::deque<Pending> pending_;
  std::deque<std::unique_ptr<Readback>> flags_;
};

} // namespace pliant
