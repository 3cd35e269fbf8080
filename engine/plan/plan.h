// The plan: what a scene needs, from its components to kernels and buffers. What is not in the plan is not
// allocated, not compiled, not dispatched and not written; a step asks the plan, never the scene.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/method.h"
#include "engine/plan/spec.h"

#include <memory>
#include <string>
#include <vector>

namespace pliant {

struct DirectPlan;
struct Hierarchy;

/// What the caller wants besides the motion itself.
struct PlanRequest {
  bool statistics = true;          ///< a row of energies, momentum and residuals each step
  bool divergence = false;         ///< the last good state kept, and a row each step that tells a bad one
  bool frames = false;             ///< world positions, for files and pictures
  std::vector<std::string> fields; ///< "velocity", "displacement", "strain", "energy", "damage",
                                   ///< "plastic_strain": only with frames
  bool surfaces = true;            ///< carried meshes, where there are any: only with frames
};

struct Plan {
  // Components.
  bool bdf2 = false, held = false, loaded = false, momentum = false, statistics = false, energy = false,
       divergence = false;
  bool boundaries = false, pairs = false;
  bool sheets = false, plane = false; ///< flat neighbourhoods; all of them in one plane
  bool failure = false;
  /// failure: row of `shape` with the share of the weights that is left; the next counts breaks
  std::uint32_t share_row = 0;
  bool plastic = false;
  bool fluid = false;         ///< and nothing else: no fixed bonds, no energies
  bool fluid_forces = false;  ///< of them, viscosity or redistribution
  bool fluid_bonds = false;   ///< of them, bonds between neighbours of now: an elastic solve a step
  bool fluid_flow = false;    ///< and these flow
  bool fluid_sources = false; ///< emitters or sinks
  Method method;
  std::shared_ptr<const Hierarchy> hierarchy; ///< null without the multilevel preconditioner
  std::shared_ptr<const DirectPlan> direct;   ///< null without the constant matrix's factor
  bool frames = false, surfaces = false, strain = false;

  std::size_t particles = 0, bonds = 0;
  std::vector<BufferSpec> buffers;
  std::vector<KernelSpec> kernels;         ///< variants: a kernel may come more than once
  std::vector<std::string> used, left_out; ///< names of components

  /// Bytes on a device of this precision; of the bond buffers alone, of the rest alone.
  std::size_t bytes(Precision precision) const;
  double bytes_per_bond(Precision precision) const;
  double bytes_per_particle(Precision precision) const;
  const BufferSpec* find(const std::string& name) const;
};

Plan make_plan(const Scene& scene, const Model& model, const SlicedBonds& bonds, const PlanRequest& request);

/// Compiles every variant that the plan lists, so that no step has to.
void prepare_kernels(Device& device, const Plan& plan);

/// A run of at most chunk_size particles of one component: the unit of sums.
inline constexpr std::uint32_t chunk_size = 1024;
struct Chunks {
  std::vector<Uint4> chunk; ///< first particle, one past the last, component, 0
  std::vector<Uint4>
      component; ///< first chunk, one past the last, 1 if its law conserves angular momentum, 0
};
Chunks make_chunks(const Model& model);

} // namespace pliant
