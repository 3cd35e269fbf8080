// Chooses the global step.
#include "engine/plan/method.h"

#include "engine/core/error.h"
#include "engine/scene/scene.h"
#include "engine/solver/stiffness.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace pliant {

namespace {

constexpr std::array methods{"auto", "chebyshev", "jacobi", "position", "direct", "lbfgs", "newton"};
constexpr std::array preconditioners{"auto", "diagonal", "multilevel", "direct"};

bool has(const Model& model, Law law) {
  return std::any_of(model.laws.begin(), model.laws.end(),
                     [law](const LawRange& range) { return range.law == law && range.count > 0; });
}

bool touches(const Scene& scene, const Model& model) {
  return !scene.boundaries.empty() || (scene.contact.bodies && model.bodies.size() > 1) || scene.contact.self;
}

// Slipping with friction does work that depends on the path.
bool slips_with_friction(const Scene& scene, const Model& model) {
  const bool touching = (scene.contact.bodies && model.bodies.size() > 1) || scene.contact.self;
  return (touching && scene.contact.friction > 0) ||
         std::any_of(scene.boundaries.begin(), scene.boundaries.end(),
                     [](const Boundary& b) { return b.slip && b.friction > 0; });
}

// Chebyshev's iterations grow with the root of the stiffness number, Newton's hardly at all: they meet here.
// Where bodies touch, Newton follows every contact that opens, closes or slips, and the coarse levels know
// the obstacles only: they meet later.
constexpr double stiff = 1e3, stiff_touching = 1e4;
constexpr double nearly_incompressible = 0.4;
constexpr double tight = 1e-4;
constexpr double worth_a_matrix = 50; ///< stiffness number below which the diagonal says all
/// Of the sheets and shells of the examples, stiffness numbers up to 1.2e4, L-BFGS over the factor was level
/// with the best or ahead by twice (trampolines). Not where bodies touch: its long steps take them through
/// sheets.
constexpr double stiff_factored = 1e5;

/// Where stiffness changes with stretch, coarse levels lead L-BFGS past saddles of the potential on which it
/// creeps. Iterations a step with and without them: an armadillo of A4, stiffness number 1.1e3, 97 and 43; a
/// flower, 2e4, 48 and 252.
constexpr double stiff_diagonal = 1e4;

/// A matrix that is factorised once knows nothing of what breaks.
bool breaks(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const Material& material) { return material.breaks(); });
}

/// Whether stiffness changes with stretch in this scene, so that what bounds it at rest bounds it no longer.
bool stiffens(const Model& model) {
  for (const StretchEnergy& energy : model.stretch)
    for (const BasisSum* sum : {&energy.bond, &energy.volume})
      for (const BasisTerm& term : sum->terms)
        if (term.kind != BasisTerm::Kind::B || term.n != 1) return true;
  return false;
}

/// Whether the constant matrix's factor is short: of sheets and of scenes in a plane, and of the solids
/// beside them while there are few.
bool short_factor(const Scene& scene, const Model& model) {
  constexpr std::ptrdiff_t most_solid = 20000;
  if (model.dimension == 2) return true;
  if (!model.has_sheets()) return false;
  const auto solid = [&](std::uint32_t material) { return material < scene.materials.size(); };
  return std::count_if(model.material.begin(), model.material.end(), solid) <= most_solid;
}

/// Whether an energy error ends a step: the one typed, or the one assumed where sweeps would not do anyway.
/// L-BFGS then needs a third of Newton's time, which solves far beyond it where contacts open and close.
bool energy_ends(const Scene& scene, const Model& model) {
  if (!scene.solver.energy_tolerance || slips_with_friction(scene, model)) return false;
  return !scene.solver.energy_assumed || stiffens(model);
}

} // namespace

Method choose_method(const Scene& scene, const Model& model) {
  Method method;
  method.name = scene.solver.method;
  method.stiffness_number = stiffness_of(model, whole_step(scene)).number;
  const double eta = method.stiffness_number;
  const bool projective = has(model, Law::projective);
  const double limit = touches(scene, model) ? stiff_touching : stiff;
  if (method.name == "auto") {
    double ratio = 0;
    for (const Material& material : scene.materials) ratio = std::max(ratio, material.poisson);
    if (projective) {
      method.name = "chebyshev";
      method.reason = "the projective law has no potential to descend";
    } else if (energy_ends(scene, model)) {
      method.name = "lbfgs";
      method.reason = "steps end by their energy error, which it reaches soonest";
    } else if (eta > worth_a_matrix && eta <= stiff_factored && short_factor(scene, model) &&
               !breaks(scene) && !touches(scene, model)) {
      method.name = "lbfgs";
      method.reason = "the constant matrix has a short factor";
    } else if (has(model, Law::basis) && stiffens(model)) {
      method.name = "newton";
      method.reason = "a law over basis functions stiffens with stretch, beyond what sweeps are bounded by";
    } else if (eta > limit || ratio > nearly_incompressible || scene.solver.tolerance < tight) {
      method.name = "newton";
      method.reason =
          eta > limit ? fmt::format("the stiffness number {:.3g} is above {:g}", eta, limit)
          : ratio > nearly_incompressible
              ? fmt::format("a Poisson's ratio of {:g} is above {:g}", ratio, nearly_incompressible)
              : fmt::format("the tolerance {:g} is below {:g}", scene.solver.tolerance, tight);
    } else {
      method.name = "chebyshev";
      method.reason = fmt::format("the stiffness number {:.3g} is not above {:g}", eta, limit);
    }
  }
  if (method.name == "newton" && projective)
    throw Error(
        ExitCode::usage,
        "solver.method \"newton\": the projective law has no potential, so no symmetric derivative to "
        "solve with; choose chebyshev, lbfgs or direct, or law = \"corotated\"");
  method.line_search = method.name == "newton" || method.name == "lbfgs" || method.name == "direct";
  method.potential = method.line_search && !projective && !slips_with_friction(scene, model);
  if (method.potential) method.energy_tolerance = scene.solver.energy_tolerance.value_or(0);
  if (method.name == "direct") {
    method.preconditioner = "direct";
  } else if (method.line_search) {
    method.preconditioner = scene.solver.preconditioner;
    const bool flat = model.dimension == 2 || model.has_sheets();
    if (method.preconditioner == "multilevel" && model.dimension == 2)
      throw Error(ExitCode::usage,
                  "solver.preconditioner \"multilevel\": its coarse elements are solid and would push "
                  "particles out of the plane of a scene of dimension 2; choose diagonal or direct");
    if (method.preconditioner == "auto") {
      // A sheet's factor is short, and its coarse elements do not bend as it does.
      const bool factor = method.name == "lbfgs" && short_factor(scene, model);
      const bool creeps = method.name == "lbfgs" && stiffens(model) && eta <= stiff_diagonal;
      method.preconditioner = eta <= worth_a_matrix ? "diagonal"
                              : factor              ? "direct"
                              : flat || creeps      ? "diagonal"
                                                    : "multilevel";
      if (eta > worth_a_matrix && flat)
        method.reason += std::string(method.reason.empty() ? "" : "; ") + method.preconditioner +
                         ", since coarse elements do not bend as sheets do";
      else if (eta > worth_a_matrix && creeps && !factor)
        method.reason +=
            std::string(method.reason.empty() ? "" : "; ") +
            "diagonal, since coarse levels lead it past saddles of a law that stiffens with stretch";
    }
  }
  return method;
}

std::span<const char* const> method_names() {
  return methods;
}
std::span<const char* const> preconditioner_names() {
  return preconditioners;
}

} // namespace pliant
