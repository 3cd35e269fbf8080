// The plan for people and for programs.
#pragma once

#include "engine/plan/plan.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace pliant {

/// "predict[bdf2=0,loaded=1]": as devices name what they have compiled.
std::string variant_name(const KernelSpec& kernel);

/// Components with their kernels, what is left out, buffers with bytes, totals.
std::string plan_text(const Plan& plan, Precision precision);
/// {components {used [], left_out []}, kernels [], buffers [{name, bytes}], bytes_per_particle,
/// bytes_per_bond}. `kernels` has each name once, whatever its variants.
nlohmann::json plan_json(const Plan& plan, Precision precision);

} // namespace pliant
