// The order in which a matrix over bonded particles is eliminated, and the fronts of its Cholesky factor:
// nested dissection (George 1973) by planes through the reference positions. Each separator, and each set of
// particles too small to be cut again, is one dense front; those of one level depend on lower levels only.
#pragma once

#include "engine/model/model.h"

#include <array>
#include <cstdint>
#include <vector>

namespace pliant {

/// A front eliminates `columns` unknowns, in places [first, first + columns) of the order. Its rows are the
/// places that these are coupled to and that are eliminated later, ascending.
struct Front {
  std::uint32_t first = 0, columns = 0;
  std::uint32_t row_begin = 0, row_end = 0; ///< into Dissection::row
  std::array<std::int32_t, 2> child{-1, -1};
  std::uint32_t level = 0; ///< above those of its children
  std::uint32_t rows() const { return row_end - row_begin; }
};

struct Dissection {
  std::vector<std::uint32_t> order; ///< particle in each place; those that are not free are in none
  std::vector<std::uint32_t> place; ///< of each particle; `nowhere` for those
  std::vector<Front> fronts;        ///< children before their parents
  std::vector<std::uint32_t> row;   ///< places, front after front
  std::uint32_t levels = 0;
  static constexpr std::uint32_t nowhere = ~0u;
  /// Which of a front's columns and rows a place is; it must be one of them.
  std::uint32_t within(const Front& front, std::uint32_t wanted) const;
  /// Entries of the factor, with the zeros of its dense blocks.
  double entries() const;
};

/// Of the particles that are ever free, and of the bonds between them.
Dissection dissect(const Model& model);

} // namespace pliant
