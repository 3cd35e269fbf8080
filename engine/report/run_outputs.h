// The files of a run's folder but for run.json: opened anew, or brought back to a checkpoint and gone on
// with.
#pragma once

#include "engine/io/checkpoint.h"
#include "engine/io/film.h"
#include "engine/io/run_writer.h"
#include "engine/io/statistics_writer.h"
#include "engine/render/renderer.h"
#include "engine/solver/simulation.h"

namespace pliant {

class RunOutputs {
public:
  RunOutputs(std::filesystem::path folder, const Scene& scene, const Model& model, Simulation& simulation,
             bool pictures, bool video);

  /// Makes the folder. Throws Error(input_output) where it holds something.
  void open();
  /// Drops what was written after the checkpoint. Throws Error(input_output), Error(usage).
  void resume(const RunProgress& progress);

  void append(StatisticsRow row);
  void write_frame(unsigned frame);
  /// How far the files are, all of it on the disk.
  RunProgress progress() const;
  void close();

  const std::filesystem::path& folder() const { return folder_; }
  const std::vector<std::string>& components() const { return components_; } ///< timed, in order
  const std::vector<StatisticsRow>& rows() const { return rows_; }           ///< of the whole run
  unsigned frames() const { return frames_; }                                ///< written

private:
  std::vector<BodyOutput> blocks() const;
  void write_data(unsigned frame);

  std::filesystem::path folder_;
  const Scene& scene_;
  const Model& model_;
  Simulation& simulation_;
  bool video_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<RunWriter> writer_;
  std::unique_ptr<StatisticsWriter> statistics_;
  std::unique_ptr<Film> film_;
  std::vector<std::string> components_;
  std::vector<StatisticsRow> rows_;
  unsigned frames_ = 0;
};

/// Hash of all that a scene says, of its particles and of the meshes of its obstacles.
std::string scene_fingerprint(const Scene& scene, const Model& model);

/// Empties a folder that holds nothing but files of a run; leaves any other alone.
void clear_run(const std::filesystem::path& folder);

} // namespace pliant
