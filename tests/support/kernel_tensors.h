// Inverse shape tensors for tests of kernels: any symmetric matrix will do, since a kernel only multiplies by
// it.
#pragma once

#include "tests/support/kernel_bonds.h"

namespace pliant::test {

inline Matrix3 cofactor_of(const Matrix3& f) {
  Matrix3 c;
  for (int k = 0; k < 3; ++k) c.col(k) = f.col((k + 1) % 3).cross(f.col((k + 2) % 3));
  return c;
}

/// The six rows of a buffer from `row` on, in the order xx xy xz yy yz zz, of particle i of the range.
inline Matrix3 symmetric_at(const std::vector<double>& rows, const BondProblem& p, std::size_t i,
                            std::size_t row) {
  const auto at = [&](std::size_t k) { return rows[(row + k) * p.total + p.first + i]; };
  return (Matrix3() << at(0), at(1), at(2), at(1), at(3), at(4), at(2), at(4), at(5)).finished();
}

/// Fills them: near three times the identity, as it is of a full neighbourhood.
inline Matrix3 symmetric_rows(std::vector<double>& rows, Random& random, const BondProblem& p, std::size_t i,
                              std::size_t row) {
  for (std::size_t k = 0; k < 6; ++k)
    rows[(row + k) * p.total + p.first + i] = rounded((k == 0 || k == 3 || k == 5 ? 3 : 0) + 0.5 * random());
  return symmetric_at(rows, p, i, row);
}

} // namespace pliant::test
