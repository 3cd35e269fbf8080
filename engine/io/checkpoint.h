// Checkpoints: FOLDER/checkpoints/step-XXXXXXXX.h5, all that a run needs to go on bit for bit.
//
//   @format, @record (JSON: who wrote it, how far it was), @checksum
//   /state/<buffer>     bytes as the device stores them
//   /data/bulk, /rest   how to bring run.vtkhdf back to that moment
//
// Written beside its place, on the disk before it is renamed; the last two are kept.
#pragma once

#include "engine/io/run_mark.h"
#include "engine/solver/saved_state.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace pliant {

/// Who can go on from a checkpoint: the same bits come only from the same of each. The number of threads
/// changes no bit.
struct CheckpointIdentity {
  std::string scene;                              ///< hash of all that the scene says and of its meshes
  std::string build;                              ///< hash of the program
  std::string backend, device, driver, precision; ///< precision: float or double
  bool operator==(const CheckpointIdentity&) const = default;
};

/// How far the other files of the run were.
struct RunProgress {
  std::uint64_t frames = 0; ///< written, frame 0 included
  std::uint64_t statistics_bytes = 0;
  double wall_seconds = 0;
  std::uint64_t retries = 0, divided_steps = 0;
  bool pictures = false;
  std::optional<RunMark> data; ///< of run.vtkhdf, where there is one
};

struct Checkpoint {
  CheckpointIdentity identity;
  RunProgress progress;
  SavedState state;
};

/// Writes a checkpoint of the run in `folder` and removes all but the last two. Throws Error(input_output).
void write_checkpoint(const std::filesystem::path& folder, const Checkpoint& checkpoint);

/// Reads one. Throws Error(input_output) naming the file: damaged, or of another format.
Checkpoint read_checkpoint(const std::filesystem::path& file);

/// The newest whole checkpoint of the run in `folder`; nothing where it has none at all. Damaged ones that
/// are newer are told to `say`. Throws Error(input_output): all are damaged, or it is of another scene, build
/// or device, and which.
std::optional<Checkpoint> find_checkpoint(const std::filesystem::path& folder,
                                          const CheckpointIdentity& wanted,
                                          const std::function<void(const std::string&)>& say);

/// Removes checkpoints of later steps: after a resume they would pass for newer ones.
void drop_checkpoints_after(const std::filesystem::path& folder, std::uint64_t step);

/// FNV-1a of whole words, as 16 hexadecimal digits: to recognise damage and difference, not malice.
class Fingerprint {
public:
  void add(std::span<const std::byte> bytes);
  void add(const std::string& text) { add(std::as_bytes(std::span(text))); }
  std::string text() const;
  std::uint64_t value() const { return value_; }

private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

/// Fingerprint of the program that runs.
const std::string& build_fingerprint();

} // namespace pliant
