// Plastic flow at the end of a step: where a neighbourhood of law M2 is strained beyond what it bears, the
// rest lengths of its bonds change until it is at its yield surface (He, Wang and Wu 2017, section 5, Eqs. 14
// to 18 with the constants of engine/model/plasticity.h).
//
//   flow     e_iso, q and the return of every particle; then the rest lengths of both ends of every bond
//   sums     of the step: particles that flowed, work, largest strain, volume
//
// Each end of a bond has its own rest length, and changes it by its own particle's return alone. So every
// particle is on its surface afterwards exactly, whatever its neighbours do, and its energy falls by
//
//   V [b beta (2 - beta) <e_dev^2> + a alpha (2 - alpha) e_iso^2] >= 0,   alpha, beta in 0..1 the shares lost
//
// which is the plastic work. Averaging the shares of both ends gives neither. The ends of a bond do not
// drift apart: both are within what their particles bear of the length that the bond has.
//
// Rest lengths are kept by bond, as weights are; the elastic solve of a step sees those of its start, so the
// stress in a step exceeds the surface by what its own strain adds.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/plan.h"

#include <memory>

namespace pliant {

struct SimulationState;

class PlasticFlow {
public:
  /// All must outlive it; `unit` of packed bond vectors, m. Throws Error(usage) as yield_surfaces() does.
  PlasticFlow(Device& device, const Scene& scene, const Model& model, const Plan& plan,
              SimulationState& state, double unit);

  void flow();
  /// A row on its way to the host: particles that flowed, J, largest strain, m3.
  std::unique_ptr<Readback> sums(std::uint32_t row);
  /// Equivalent plastic strain of every particle.
  std::vector<double> strain();

private:
  Device& device_;
  const Model& model_;
  const Plan& plan_;
  SimulationState& state_;
  double unit_ = 0;
  double equivalent_ = 0;
};

} // namespace pliant
