// Cholesky's factor of the constant matrix A = M / h^2 + L of projective dynamics (He, Wang and Wu 2017,
// section 4.2), front by front, in the form that solving wants.
//
// A front with columns c and rows r of the factor [L_cc; L_rc] is kept as
//
//   P = [L_cc^-1; -L_rc L_cc^-1]
//
// so that going up is one product, [y_c; update of r] = P b_c, and coming down another, x_c = P^T [y_c; x_r]:
// no substitution, whose steps wait for each other. Both are stored in blocks of 16 outputs, an input's 16
// coefficients side by side; zeros above the diagonal are left out by whole blocks.
#pragma once

#include "engine/model/dissection.h"
#include "kernels/kernel.h"

namespace pliant {

/// Where things are, before any number is known. A front's slots are its columns, then its rows, then
/// padding to a multiple of 16; one more slot, which stays zero, ends them all.
struct FactorLayout {
  std::vector<Uint4> slot; ///< particle; slots of the children that add to it (or the zero slot); 1: a column
  std::vector<Uint4> up;   ///< a block of 16 slots: first coefficients / 16, first slot, inputs, output
  std::vector<Uint4> down; ///< first coefficients / 16, first slot, columns and rows, output and first input
  std::vector<std::uint32_t> up_begin, down_begin; ///< blocks of each level; one more than there are levels
  std::size_t coefficients_up = 0, coefficients_down = 0;
  std::vector<std::uint32_t> first_slot, first_up, first_down; ///< of each front
};
FactorLayout lay_out(const Dissection& dissection);

struct Factor {
  std::vector<double> up, down; ///< (m/N)^(1/2) where columns meet, else no unit
};
/// `step`: h of M / h^2, s. Throws Error(internal) where the matrix is not positive definite.
Factor factorise(const Model& model, const Dissection& dissection, const FactorLayout& layout, double step);

} // namespace pliant
