// What each law takes from Young's modulus and Poisson's ratio, by exact averages over the sphere of
// directions.
#include "engine/core/error.h"
#include "engine/model/lame.h"
#include "engine/model/model.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

/// Of a disc; see law_constants in model.h.
LawConstants flat_constants(Law law, double young, double poisson, double split,
                            Neighbourhood neighbourhood) {
  const bool stress = neighbourhood == Neighbourhood::plane_stress;
  LawConstants constants;
  if (law == Law::neo_hookean)
    throw Error(ExitCode::usage,
                "law neo-hookean needs neighbours in all three directions: in sheets and plane "
                "scenes choose form = \"bonds\", or another law");
  if (law == Law::projective) {
    const double ratio = stress ? 1. / 3 : 0.25;
    if (std::abs(poisson - ratio) > 1e-9)
      throw Error(
          ExitCode::usage,
          fmt::format("the projective law has Poisson's ratio {} in {}, whatever its constants, not {}; "
                      "set that or choose another law",
                      stress ? "1/3" : "1/4", stress ? "sheets and plane stress" : "plane strain", poisson));
    constants.modulus = stress ? 3 * young : 3.2 * young;
    constants.coupling = split;
    return constants;
  }
  const double most = stress ? 0.95 : 0.499;
  if (!(poisson >= 0 && poisson <= most))
    throw Error(ExitCode::usage,
                fmt::format("Poisson's ratio must lie in 0 to {} in {} (nothing resists shear as much as "
                            "compression would at {}), not at {}",
                            most, stress ? "sheets and plane stress" : "plane strain", stress ? 1 : 0.5,
                            poisson));
  const auto [shear, lame] = lame_constants(young, poisson, neighbourhood);
  if (law == Law::corotated) {
    constants.modulus = 4 * shear;
    constants.coupling = lame / shear;
  } else {
    const double a = 2 * (lame + shear), b = 4 * shear;
    constants.modulus = 2 * b;
    constants.coupling = (a - b) / b;
  }
  constants.bound = 1 + std::max(constants.coupling, 0.0);
  return constants;
}

} // namespace

LawConstants law_constants(Law law, double young, double poisson, double split, Neighbourhood neighbourhood) {
  if (!(young > 0) || !std::isfinite(young))
    throw Error(ExitCode::usage,
                fmt::format("Young's modulus must be a positive number of pascals, not {}", young));
  if (!(split >= 0 && split <= 1))
    throw Error(ExitCode::usage,
                fmt::format("the split of the projective law lies in 0 to 1, not at {}", split));
  if (neighbourhood != Neighbourhood::solid) return flat_constants(law, young, poisson, split, neighbourhood);
  LawConstants constants;
  if (law == Law::projective) {
    // Homogeneous deformation: W = (mu_1 + lambda_1 / 2) <(s - 1)^2>, whatever the split, and the ratio is
    // 1/4.
    if (std::abs(poisson - 0.25) > 1e-12)
      throw Error(ExitCode::usage,
                  fmt::format("the projective law has Poisson's ratio 0.25 whatever its constants, "
                              "not {}; set 0.25 or choose another law",
                              poisson));
    constants.modulus = 6 * young;
    constants.coupling = split;
    return constants;
  }
  if (!(poisson >= 0 && poisson <= 0.499))
    throw Error(
        ExitCode::usage,
        fmt::format("Poisson's ratio must lie in 0 to 0.499 (the material's stiffness to compression is "
                    "infinite at 0.5), not at {}",
                    poisson));
  const auto [shear, lame] = lame_constants(young, poisson);
  if (law == Law::neo_hookean) {
    constants.modulus = 3 * shear;
    constants.coupling = 1.5 * lame / shear;
    constants.isochoric = 2; // bonds that follow a gradient: 2 mu_L |dF|^2, beside 3 mu_L <|dY|^2 / x^2>
    constants.bound = constants.isochoric * (1 + constants.coupling);
    return constants;
  }
  if (law == Law::corotated) {
    const double mu = 3 * shear, kappa = 4.5 * lame;
    constants.modulus = 2 * mu;
    constants.coupling = kappa / mu;
  } else {
    const double bulk = lame + 2. / 3 * shear;
    const double a = 4.5 * bulk, b = 7.5 * shear;
    constants.modulus = 2 * b;
    constants.coupling = (a - b) / b;
  }
  constants.bound = 1 + std::max(constants.coupling, 0.0);
  return constants;
}

LawConstants law_constants(const Material& material, Neighbourhood neighbourhood) {
  if (material.fluid()) return {}; // no bonds
  LawConstants constants =
      law_constants(law_of(material), material.young, material.poisson, material.split, neighbourhood);
  if (material.calibration == "xu2018") {
    if (neighbourhood != Neighbourhood::solid)
      throw Error(ExitCode::usage,
                  "calibration \"xu2018\" is of solids; sheets and plane scenes have \"exact\"");
    constants.coupling += 0.6; // Eq. 26 has lambda_2 = (9/2) lambda_L, without -(9/2) mu_L
    constants.bound = 1 + std::max(constants.coupling, 0.0);
  }
  return constants;
}

Law law_from_name(const std::string& name) {
  for (const Law law : {Law::corotated, Law::ordinary, Law::projective, Law::basis})
    if (name == law_name(law)) return law;
  throw Error(ExitCode::usage,
              fmt::format("there is no law \"{}\"; laws are corotated, ordinary, projective, basis, stvk and "
                          "neo-hookean",
                          name));
}

Law law_of(const Material& material) {
  if (material.fluid()) return Law::fluid;
  if (material.law == "stvk") return Law::basis;
  if (material.law == "neo-hookean") return material.form == "bonds" ? Law::basis : Law::neo_hookean;
  return law_from_name(material.law);
}

const char* law_name(Law law) {
  switch (law) {
  case Law::corotated:
    return "corotated";
  case Law::ordinary:
    return "ordinary";
  case Law::projective:
    return "projective";
  case Law::basis:
    return "basis";
  case Law::neo_hookean:
    return "neo-hookean";
  case Law::fluid:
    return "fluid";
  }
  return "unknown";
}

} // namespace pliant
