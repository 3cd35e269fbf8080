// Contacts of a simulation: which buffers and kernels a scene needs for them, and when they run.
//
//   plan_contacts(scene, model)   what will be allocated and run; nothing where nothing can touch
//   Contacts                      once a step:      begin_step   obstacles go to their place at its end
//                                 now and then:     find         cells, then lists of contacts
//                                 every iteration:  add_forces   right after the elastic forces
//
// A contact is a penalty 1/2 k depth^2 with k the particle's own elastic stiffness K_i, so that it is neither
// softer nor stiffer to solve than the body: convex in each direction, once differentiable, and evaluated
// anew in every iteration. Friction is a spring against tangential displacement over the step, cut off at mu
// N with N of the same iterate.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/method.h"
#include "engine/plan/spec.h"
#include "engine/solver/contact_obstacles.h"

#include <map>

namespace pliant {

/// Buffers of the solver that contacts read and add to. The bonds only where bodies may touch themselves, the
/// energy only where the solver looks at the potential.
struct ContactState {
  BufferStorage* position = nullptr;     ///< real4, m, relative to the body's origin; w: mass
  BufferStorage* displacement = nullptr; ///< real4, m: the iterate
  BufferStorage* owner = nullptr;        ///< uint, body
  BufferStorage* origin = nullptr;       ///< real4 a body, m, relative to the scene's
  BufferStorage* linear_start = nullptr; ///< real4; w: K_i, N/m
  BufferStorage* solver = nullptr;       ///< real
  BufferStorage* force = nullptr;        ///< real4, N; w: stiffness of the diagonal, N/m
  BufferStorage* slice_begin = nullptr;  ///< uint
  BufferStorage* bond = nullptr;         ///< uint
  BufferStorage* energy = nullptr;       ///< real, J
};

/// What a solver asks of contacts besides forces.
struct ContactUse {
  bool potential = false; ///< their energy is added to that of the particles
  bool tangent = false;   ///< products with the derivative of their forces
};
ContactUse contact_use(const Method& method);

/// What a scene needs for contacts.
struct ContactPlan {
  bool boundaries = false; ///< obstacles
  bool between = false;    ///< particles of different bodies
  bool within = false;     ///< particles of one body
  bool meshes = false;     ///< an obstacle is a distance grid
  std::uint32_t particles = 0, cells = 0, chunks = 0;
  double radius = 0;   ///< m; half a spacing: surfaces rest on obstacles, not the outermost centres
  double distance = 0; ///< m; between centres of touching particles
  ContactUse use;
  double reach = 0; ///< m; lists hold what is closer than this: distance plus margin()
  std::vector<BufferSpec> buffers;
  std::vector<KernelSpec> kernels;
  bool pairs() const { return between || within; }
  bool any() const { return boundaries || pairs(); }
  /// Where steps begin, gathered in one buffer: for pairs, and for obstacles in a line search.
  bool started() const { return pairs() || (boundaries && (use.potential || use.tangent)); }
  /// m; lists stay complete while no two particles have approached each other by more than this since find().
  double margin() const { return reach - distance; }
};
/// Throws Error(usage): more than 32 boundaries, a mesh that will not do; Error(too_large).
ContactPlan plan_contacts(const Scene& scene, const Model& model, ContactUse use = {});

/// Contacts that found no room in the last find(): they are dropped on both sides.
struct ContactOverflow {
  std::uint32_t contacts = 0, particles = 0;
};

class Contacts {
public:
  /// Allocates what plan_contacts() lists, and samples the distance of mesh obstacles.
  /// Device coordinates are relative to `scene_origin`, m, world.
  Contacts(Device& device, const Scene& scene, const Model& model, const Vector3& scene_origin,
           ContactUse use = {});

  const ContactPlan& plan() const { return plan_; }
  /// Compiles every kernel, so that no step has to.
  void prepare();
  /// A step from `time` to `time + step`, s: after positions have been advanced, before find() and
  /// add_forces().
  void begin_step(double time, double step, const ContactState& state);
  /// Lists of contacts at the current iterate. Nothing where particles cannot touch each other.
  void find(const ContactState& state);
  /// Adds to `force`. Does nothing once the solver has stopped.
  void add_forces(const ContactState& state);
  /// Adds the derivative of the forces between particles along `direction` to `force`, at `displacement`; the
  /// obstacles' own is in block(). Only where the plan's use has a tangent.
  void add_product(const ContactState& state, BufferStorage* displacement, BufferStorage* direction);
  /// real4, two a particle: -df/du of the obstacles' forces in the last add_forces(), N/m; null without.
  BufferStorage* block() const { return buffer("contact_block"); }

  /// uint a particle, 1 where a contact acted in the last add_forces(); null where nothing can touch.
  BufferStorage* touched() const { return plan_.any() ? buffer("touched") : nullptr; }
  /// Waits for the device.
  ContactOverflow overflow();
  /// For tests and the report: a buffer of the plan by name; null when it is not in it.
  BufferStorage* buffer(const std::string& name) const;

private:
  template <class Visit> void each_kernel(const ContactState& state, Visit visit);

  Device& device_;
  ContactPlan plan_;
  Obstacles obstacles_;
  std::map<std::string, Buffer> buffers_;
  double friction_ = 0, lightest_ = 0, least_stiffness_ = 0; ///< -, kg, N/m
  bool still_ = false;               ///< no obstacle moves: the table holds for every step
  Vector3 origin_ = Vector3::Zero(); ///< m, world: of the device's coordinates
  Vector3 base_ = Vector3::Zero();   ///< m: the bodies' middle, relative to it
};

} // namespace pliant
