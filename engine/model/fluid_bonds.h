// Bonds of fluids that have some (model = "viscoelastic"): law M2, the linear peridynamic solid, between the
// neighbours of now, whose rest lengths are all that a step leaves to the next (He, Wang and Wu 2017, section
// 6).
//
// Weights of bonds, by their length at the start of a step, vanish with their slope at the reach of lists, so
// that neighbours come and go without a force:
//
//   w(y) = (1 - q)^2 (w0 + w2 q + w4 q^2),   q = (y / reach)^2
//
// in the one mixture of neighbouring powers of q that makes the lattice isotropic, <N_1^4> = 1/5 (in the
// plane 3/8), so that Young's modulus is the one typed along all its directions: at the default reach
// exactly; the reaches where no mixture does it say what they give. They sum to 1 on the lattice.
// Averages (e_iso, the rms of e - e_iso) are over a particle's own bonds, and what it bears is shared out
// among them, as long as their weights sum to nine tenths: matter in disorder has the moduli typed. Below
// that bonds get no stronger, so that a lonely pair is weak: at surfaces matter is as much softer as
// neighbours are fewer.
#pragma once

#include "engine/model/fluid.h"
#include "engine/model/plasticity.h"

namespace pliant {

/// Of one fluid material; see shaders/common/fluid_bond.glsl.
struct FluidElasticity {
  double bond = 0;       ///< J: 2 V b; 0: no bonds
  double volumetric = 1; ///< a / b
  double relaxation = 0; ///< s; 0: stress stays
  YieldSurface surface;  ///< infinite strength where it does not yield
  bool plastic = false;
};

struct FluidBonds {
  bool any = false;     ///< some particle is of a material with bonds
  bool coupled = false; ///< a differs from b: bonds feel the dilatation
  bool plastic = false, relaxes = false;
  double weight[3] = {0, 0, 0};           ///< w0, w2, w4
  double isotropy = 0;                    ///< <N_1^4> of the lattice, over that of isotropic matter
  double bound = 1;                       ///< the largest of 1 and a / b
  double equivalent = 1;                  ///< equivalent strain of a deviatoric one of mean square 1
  double stiffness = 0;                   ///< 1/s2: the largest K_i / m_i on the lattice
  std::vector<FluidElasticity> materials; ///< of each fluid material, in the scene's order
  bool flows() const { return plastic || relaxes; }
};

/// Throws Error(usage): constants out of their range, as law_constants() and yield_surface() do.
FluidBonds fluid_bonds(const Scene& scene, const Model& model, const FluidModel& fluid);

/// Weight of a bond of squared length q reach^2.
double bond_weight(const FluidBonds& bonds, double q);

} // namespace pliant
