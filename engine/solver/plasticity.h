// Plastic flow at the end of a step: where a neighbourhood of law M2 is strained beyond what it bears, the
// rest lengths of its bonds change until it is at its yield surface (He, Wang and Wu 2017, section 5, Eqs. 14
// to 18 with the constants of engine/model/plasticity.h).
//
//   flow     e_iso, q and the return of every particle; then the rest lengths of both ends of every bond
//   sums     of the step: particles that flowed, work, largest strain, volume
//
// Each end of a bond has its own rest length, and changes it by its own particle's return alone. So every
// particle is on its surface afterwards exactly, whatever its neighbours do. Averaging the shares of both
// ends would not do that; the ends of a bond do not drift apart: both are within what their particles bear of
// the length that the bond has. The work of the flow is that of the stress that stays,
//
//   2 V [b beta (1 - beta) <e_dev^2> + a alpha (1 - alpha) e_iso^2] >= 0,   alpha, beta in 0..1 the shares
//   lost
//
// and not all of what a particle's energy falls by: what lies above the surface was never there but in a
// solve that did not know of the flow, and the next one gives it back as motion.
//
// Rest lengths are kept by bond, as weights are. The elastic solve of a step sees those of its start, so that
// stresses exceed the surface by what the step's strain adds, and are out of balance once they are returned
// to it. Where anything yielded, a step therefore is solved and returned again, until a return finds nothing
// more to take than a small share, or a few times have not sufficed.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/plan/plan.h"

#include <memory>

namespace pliant {

struct SimulationState;

/// Share of its strain that a particle may lose in a step's last return: stresses are out of balance by as
/// much. Smaller ones cost rounds.
inline constexpr double yield_tolerance = 1e-3;
/// Solves in a step, within its cap of iterations. Each leaves about a third of the excess where strain
/// spreads, more where it gathers.
inline constexpr unsigned most_plastic_rounds = 5;

class PlasticFlow {
public:
  /// All must outlive it; `unit` of packed bond vectors, m. Throws Error(usage) as yield_surfaces() does.
  PlasticFlow(Device& device, const Scene& scene, const Model& model, const Plan& plan,
              SimulationState& state, double unit);

  void flow();
  /// The largest share of its strain that a particle lost in the last flow(); `row` of the sums is
  /// overwritten. Waits.
  double excess(std::uint32_t row);
  /// A row on its way to the host: particles that flowed, J, largest strain, m3; that share.
  std::unique_ptr<Readback> sums(std::uint32_t row);
  /// Equivalent plastic strain of every particle.
  std::vector<double> strain();

private:
  void sum(std::uint32_t row);

  Device& device_;
  const Model& model_;
  const Plan& plan_;
  SimulationState& state_;
  double unit_ = 0;
  double equivalent_ = 0;
};

} // namespace pliant
