// The keys of a scene file, part four: fluids and their domain.
#include "engine/scene/scene_schema_slot.h"

namespace pliant::schema {

const Table& fluid_table() {
  using F = FluidSettings;
  constexpr Range iterations{.low = 0, .high = 1000};
  static const Table table{
      "fluid",
      "[fluid]",
      "How materials of model \"fluid\" are solved.",
      {{.name = "horizon",
        .meaning = "reach of the smoothing functions",
        .slot = at<&F::horizon>,
        .unit = "spacings",
        .range = {.low = 1.5, .high = 4.1, .why = "fewer neighbours carry no density, more cost too much"}},
       {.name = "density_iterations",
        .meaning = "sweeps of the density constraint a step",
        .slot = at<&F::density_iterations>,
        .range = {.low = 1, .high = 1000, .why = "without one nothing keeps particles apart"}},
       {.name = "redistribution_iterations",
        .meaning = "sweeps a step that spread particles evenly, where a material asks for it",
        .slot = at<&F::redistribution_iterations>,
        .range = iterations},
       {.name = "redistribution_form",
        .meaning = "how they do it: down the gradient of the density, by Newton's method, by Eq. 24 of He et "
                   "al. (2017) as printed or with the other sign",
        .slot = at<&F::redistribution_form>,
        .choices = {"fickian", "newton", "printed", "negated"}},
       {.name = "viscosity_form",
        .meaning =
            "of the force between two particles: along the difference of their velocities, or along the "
            "line of centres, which free spinning does not feel and ropes need to coil",
        .slot = at<&F::viscosity_form>,
        .choices = {"laplacian", "central"}},
       {.name = "viscosity_iterations",
        .meaning = "a cap on the sweeps of a step's viscosity",
        .slot = at<&F::viscosity_iterations>,
        .range = {.low = 1, .high = 1e6, .why = "one sweep is one evaluation of viscous forces"}},
       {.name = "viscosity_tolerance",
        .meaning = "relative residual that ends them sooner",
        .slot = at<&F::viscosity_tolerance>,
        .range = {.low = 1e-12,
                  .high = 1,
                  .why = "less than 1e-12 is lost in rounding even in double precision"}},
       {.name = "neighbours",
        .meaning = "that a particle's list has room for; by default twice those of the lattice",
        .slot = at<&F::neighbours>,
        .range = {.low = 8, .high = 1024, .why = "a full lattice must fit"},
        .example = "64"}},
      std::make_shared<F>()};
  return table;
}

const Table& domain_table() {
  using D = DomainSettings;
  static const Table table{"domain",
                           "[domain]",
                           "Where fluids may be; what leaves it is removed and counted.",
                           {{.name = "low",
                             .meaning = "lowest corner",
                             .slot = at<&D::low>,
                             .unit = "m",
                             .example = "[0, 0, 0]",
                             .required = true},
                            {.name = "high",
                             .meaning = "highest corner",
                             .slot = at<&D::high>,
                             .unit = "m",
                             .example = "[1, 1, 1]",
                             .required = true},
                            {.name = "periodic",
                             .meaning = "directions in which what leaves it comes in again on the other side",
                             .slot = at<&D::periodic>}},
                           std::make_shared<D>()};
  return table;
}

} // namespace pliant::schema
