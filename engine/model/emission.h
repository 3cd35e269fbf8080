// Emitters: how a fluid comes out of nozzles. A nozzle is a piece of the square lattice that bodies are
// filled with, across its direction; a copy of it, a layer, is born every spacing / speed seconds and goes on
// at the nozzle's speed, so that what comes out is a lattice that moves.
//
//      . . . . .   nozzle, of `point`s          layer k is born at start + k spacing / speed
//      . . . . .   one spacing on               and counts in every step that ends after that
//      . . . . .   |  velocity
//     -----------  v                            as far as the horizon from the nozzle a layer is held: it
//      . . . . .                                goes on at its speed, whatever pulls at it; then it is free
//
// What falls away faster than it comes, as honey does, hangs from the layers that are held, and thins; it
// tears where its material does. Free from the start, it would leave the nozzle by more than the horizon
// before the next layer is born, and fall apart into blocks.
//
// Particles that are yet to be born are in the model from the start, as many as there may be at once: each
// emitter is a body of its own behind those of the scene. Where nothing leaves the scene, who gets how many
// of the capacity follows from the order of births; where a domain or sinks take particles out, each emitter
// has room for all of it, and uses the room of those that are gone.
#pragma once

#include "engine/model/model.h"

namespace pliant {

struct Emission {
  std::uint32_t emitter = 0;          ///< of the scene
  std::uint32_t body = 0;             ///< of the model
  std::uint32_t first = 0, count = 0; ///< particles of the model: room
  std::vector<Vector3> point;         ///< m, relative to the middle of the nozzle
  Vector3 velocity = Vector3::Zero(); ///< m/s
  double start = 0, stop = 0;         ///< s
  double period = 0;                  ///< s, from layer to layer
  double held = 0;                    ///< s, from a layer's birth on
  std::uint64_t most = UINT64_MAX;    ///< particles that it ever emits

  /// Layers born before `time`, s; no fewer at a later one.
  std::uint64_t layers(double time) const;
  /// Particles of that many layers.
  std::uint64_t particles(std::uint64_t layers) const;
  double born(std::uint64_t layer) const { return start + static_cast<double>(layer) * period; }
};

/// Whether particles of the scene's fluids may be taken out as it goes.
bool may_leave(const Scene& scene);

/// Appends the emitters' particles to a model of the scene's bodies, without mass on the device until they
/// are born. Throws Error(usage): a nozzle that holds no particle, lies, or lets go of its layers, in an
/// obstacle or outside the domain, or lies across another; a capacity below the bodies' particles; none where
/// an emitter has no end. Error(too_large): memory.
void add_emitters(const Scene& scene, Model& model);

/// Of a model that add_emitters() has seen, in the scene's order.
std::vector<Emission> emissions(const Scene& scene, const Model& model);
/// Particles that there may be at once.
std::uint64_t capacity_of(const Scene& scene, const Model& model);

} // namespace pliant
