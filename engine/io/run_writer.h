// The visual record of a run: run.vtkhdf and, for readers that do not know it, run.xmf beside it.
//
//   /VTKHDF/<block>      flat arrays over all frames, with a table of steps: VTKHDF 2.1, ParaView 5.13 and
//   later /VTKHDF/Assembly     soft links to the blocks /frames/NNNNNN/...   views (virtual datasets) of one
//   frame's rows of the flat arrays: no copies /ids                 0, 1, 2, ...: the explicit vertex ids
//   that XDMF readers want /sim                 what wrote it run.xmf              XDMF 3 onto the views:
//   ParaView 5.11 and later
//
// A run of one block has its content at /VTKHDF itself, without an assembly (VTKHDF 2.0). Within a frame the
// data go first, then the row of steps, then a flush: a run killed between two frames leaves files that open
// with the frames so far. Nothing is compressed: float positions gain little by it, and a compressed chunk
// moves when it is rewritten.
#pragma once

#include "engine/io/run_mark.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// An array over the points of a block: 1 component or 3.
struct FieldSpec {
  std::string name; ///< letters, digits, - and _
  unsigned components = 1;
};

/// A block of the file: a cloud whose number of points may vary, or a surface of fixed triangles, or of one
/// that tears: of those that are left.
struct BodyOutput {
  enum class Kind { particles, surface };
  std::string name; ///< a letter or _, then letters, digits, - and _; a surface: "<body>_surface"
  Kind kind = Kind::particles;
  std::size_t points =
      0; ///< surface: number of vertices; particles: the number expected, for the size of chunks
  std::vector<std::array<std::uint32_t, 3>> triangles; ///< surface only
  std::vector<FieldSpec> fields;
  bool tears = false; ///< surface only: frames say which triangles are gone
};

/// A block's values of one frame.
struct BodyFrame {
  std::span<const float> positions;           ///< m; x, y, z by point
  std::vector<std::span<const float>> fields; ///< in the order of BodyOutput::fields
  std::span<const std::uint32_t> torn = {};   ///< of one that tears: a mark a triangle; not 0: gone
};

class RunWriter {
public:
  /// Creates both files in a folder that exists. Frame k is shown at k / fps seconds.
  /// Throws Error(usage) for names and sizes that the files cannot hold, Error(input_output) where writing
  /// fails.
  RunWriter(const std::filesystem::path& folder, std::vector<BodyOutput> bodies, double fps);
  /// Brings the files in the folder back to a mark and goes on from there.
  /// Throws Error(input_output) where run.vtkhdf is missing or shorter than the mark says.
  RunWriter(const std::filesystem::path& folder, std::vector<BodyOutput> bodies, double fps,
            const RunMark& mark);
  ~RunWriter();
  RunWriter(RunWriter&&) noexcept;

  /// Writes a frame and hands it to the operating system. Frame numbers ascend; gaps are allowed.
  /// Throws Error(diverged), naming body, field and particle, for a value that is not finite, and
  /// Error(input_output) for a full disk, both before anything of the frame is written.
  void append(std::uint64_t frame, const std::vector<BodyFrame>& bodies);
  std::uint64_t frames() const;
  /// The present moment, after all frames so far have reached the disk.
  RunMark mark() const;
  /// Closes the files and reports what then still goes wrong; the destructor closes in silence.
  void close();

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace pliant
