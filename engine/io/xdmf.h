// The XDMF 3 file beside a run's HDF5 file: a temporal collection of spatial collections of grids.
#pragma once

#include "engine/io/run_writer.h"

#include <filesystem>
#include <string>

namespace pliant {

class XdmfWriter {
public:
  /// `data_file`: name of the HDF5 file, beside this one.
  XdmfWriter(std::filesystem::path path, std::string data_file);
  void begin_frame(double time);
  /// A body's grid, whose views lie in `folder`. A cloud refers to `folder`/id, a surface to the dataset
  /// `corners` of so many triangles. Leave out a body that has no points, or none of its triangles.
  void add_body(const BodyOutput& body, const std::string& folder, std::uint64_t points,
                const std::string& corners, std::uint64_t triangles);
  void end_frame();
  /// Replaces the file by one with all frames, in one rename. While the text is short it does so at every
  /// call; above 4 MiB only when it has grown by 1/64, or when `now` is set, so that the bytes written stay
  /// proportional to the frames. A long run that is killed then lacks its last frames here, though not in the
  /// HDF5 file.
  void write(bool now);

private:
  std::string item(const std::string& path, const char* type, int bytes, const std::string& size) const;
  std::filesystem::path path_;
  std::string data_file_, text_;
  std::size_t written_ = 0; ///< length of the text at the last writing
};

} // namespace pliant
