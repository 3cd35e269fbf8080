// Bringing run.vtkhdf back to an earlier moment, after a kill in the middle of a write too.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace pliant {

/// A moment between two frames. Later frames never change a row that is there: they append to the bulk of the
/// data, and rewrite tables and headers. So the length of the file, and a copy of all that is not bulk, are
/// enough to come back.
struct RunMark {
  std::uint64_t frames = 0, next_frame = 0;
  std::uint64_t size = 0;                         ///< of the file, bytes
  std::vector<std::array<std::uint64_t, 2>> bulk; ///< offset and size of what is not copied, ascending
  std::vector<std::uint8_t> rest;                 ///< all other bytes, in order
};

/// Copies what is not bulk, after all of the file has reached the disk. `bulk`: in any order, repeats
/// allowed. Throws Error(input_output).
RunMark take_mark(const std::filesystem::path& file, std::vector<std::array<std::uint64_t, 2>> bulk);
/// Throws Error(input_output): the file is missing, shorter than the mark, or cannot be written.
void restore_mark(const std::filesystem::path& file, const RunMark& mark);

} // namespace pliant
