// One block of a VTKHDF file: temporal PolyData in flat arrays that grow by a frame at a time.
// Versions 2.0 and 2.1 of the format; sizes and offsets are 64-bit integers, arrays 32-bit floats.
#pragma once

#include "engine/io/hdf5.h"
#include "engine/io/run_writer.h"

namespace pliant {

/// Writes Version and the block's Type as VTK's reader expects them.
void write_vtkhdf_head(h5::Group& group, const std::string& type, std::int64_t minor_version);

class VtkHdfBlock {
public:
  /// Creates the datasets in an empty group. A surface's topology is written here, once.
  VtkHdfBlock(h5::Group group, const BodyOutput& body, std::int64_t minor_version);
  /// Goes on where the datasets of a file end.
  VtkHdfBlock(h5::Group group, const BodyOutput& body);
  /// Appends the points and fields; they do not count before append_step().
  void append_data(const BodyFrame& frame);
  /// Appends the row of steps for the data appended last, at `time` seconds.
  void append_step(double time);
  /// Makes views of the rows appended last: `folder`/position, `folder`/<field>; of a surface that tears
  /// `folder`/corners, while it has triangles. Nothing for an empty frame.
  void append_views(h5::Group& root, const std::string& folder) const;

  h5::Group& group() { return group_; }
  /// Chunks in the file that hold the bulk of the rows appended last, or of all: offset and size, bytes.
  std::vector<std::array<std::uint64_t, 2>> chunks(bool all) const;
  std::uint64_t first() const { return first_; } ///< row of the frame appended last
  std::uint64_t count() const { return count_; } ///< its points
  /// Upper bound on the growth of the file by a frame of so many points, bytes.
  std::uint64_t growth(std::uint64_t points) const;

private:
  struct Cells {
    h5::Dataset counts, id_counts, connectivity, offsets;
  };
  Cells create_cells(const std::string& name);
  Cells open_cells(const std::string& name) const;
  void append_topology();
  void append_triangles();

  h5::Group group_;
  std::vector<FieldSpec> specs_;
  bool cloud_;
  std::uint64_t chunk_rows_;
  h5::Dataset points_, point_counts_;
  std::vector<h5::Dataset> fields_;
  std::vector<Cells> cells_; ///< Vertices, Lines, Polygons, Strips
  h5::Group steps_;
  h5::Dataset values_, part_offsets_, part_counts_, point_offsets_, cell_offsets_, id_offsets_;
  std::vector<h5::Dataset> field_offsets_;
  std::uint64_t first_ = 0, count_ = 0, steps_written_ = 0;
  std::int64_t cells_before_ = 0; ///< poly-vertex cells of earlier steps; triangles of earlier topologies
  std::vector<std::array<std::uint32_t, 3>> triangles_; ///< of a surface that tears, whole
  std::vector<std::uint32_t> torn_;                     ///< its marks in the last topology
  std::int64_t topology_ = -1;                          ///< of a surface: the last one written
};

} // namespace pliant
