// Coarse levels of the bodies, for the multilevel preconditioner: trilinear finite elements on cells of 2, 4,
// 8, ... spacings of the reference lattice, with the particles as quadrature points.
//
// A cell is 2^l spacings wide and exists where it holds particles; its eight corners are nodes. Levels are
// nested: a node of a level is a node of the level below it at twice its coordinates. Each body is coarsened
// until it is one cell. All levels share one numbering of nodes and one of cells; a level begins at a
// multiple of 16 nodes.
#pragma once

#include "engine/model/model.h"

#include <array>

namespace pliant {

struct Scene;

struct HierarchyLevel {
  std::uint32_t first_node = 0, nodes = 0; ///< nodes: without padding
  std::uint32_t first_cell = 0, cells = 0;
  std::uint32_t first_gather = 0; ///< of `gather_begin`, in slices
};

struct Hierarchy {
  std::vector<HierarchyLevel> levels; ///< finest first; empty where a model has no bonds
  std::uint32_t nodes = 0;            ///< padded, of all levels
  std::uint32_t cells = 0;            ///< of all levels
  std::uint32_t blocks = 0;           ///< bodies: each is 8 nodes of the last level, in order

  /// Rotation of a cell is the mean of its particles', or of the cells in it.
  std::vector<std::uint32_t> child_begin, child; ///< a cell's particles (first level) or cells
  /// Of each node: neighbours (27, itself where there is none) in slices of 16, see neighbour_at().
  std::vector<std::uint32_t> neighbour;
  /// Of each node: the eight cells it is a corner of (no_cell where there is none), as neighbour.
  std::vector<std::uint32_t> cell;
  /// Of each cell: which of the `stiffness` tables it has. Equal cells share one.
  std::vector<std::uint32_t> signature;
  /// A table: for corners a, b of a cell 10 numbers: sum V mu grad N_a (x) grad N_b (N/m), row by row, and
  /// sum m N_a N_b (kg). Entry [(8 a + b) 12 + k]; 10: lambda / mu of the cell, mean; 11: 0.
  std::vector<double> stiffness;
  std::uint32_t signatures = 0;
  static constexpr std::uint32_t no_cell = 0xffffffffu;
  static constexpr std::uint32_t table_size = 64 * 12;

  /// Restriction: node n gathers entity `gather` times `gather_weight`; rows of 16 in slices. Entities are
  /// particles for the first level, nodes of the level below for others.
  std::vector<std::uint32_t> gather_begin, gather;
  std::vector<double> gather_weight;
  /// Interpolation: eight nodes and weights, in slices of 16: of particles (first), then of the nodes.
  std::vector<std::uint32_t> particle_node, node_parent;
  std::vector<double> particle_weight, parent_weight;
};

/// O(n) of the particles times the number of levels.
Hierarchy build_hierarchy(const Scene& scene, const Model& model);

} // namespace pliant
