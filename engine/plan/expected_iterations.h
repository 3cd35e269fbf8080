// How many iterations a step will take, before it is tried.
#pragma once

#include "engine/plan/method.h"

namespace pliant {

/// Of Chebyshev sqrt(eta / 2) ln(2 / tolerance), of Jacobi eta ln(1 / tolerance); of the others what
/// cantilevers and dropped bodies took, within a factor of three.
double expected_iterations(const Method& method, double tolerance);

} // namespace pliant
