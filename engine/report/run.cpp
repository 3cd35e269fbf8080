// The command `run`: the loop over frames, and the record of what came out.
#include "engine/report/run.h"

#include "engine/io/film.h"
#include "engine/io/folder.h"
#include "engine/io/png.h"
#include "engine/io/run_writer.h"
#include "engine/io/statistics_writer.h"
#include "engine/render/renderer.h"
#include "engine/report/progress.h"
#include "engine/scene/scene_json.h"
#include "engine/scene/scene_parse.h"
#include "engine/solver/frame.h"
#include "engine/solver/simulation.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

namespace pliant {

namespace {

using Clock = std::chrono::steady_clock;

std::atomic<int> interrupt{0};
void on_signal(int signal) {
  interrupt = signal;
}

/// Catches interrupt and termination for as long as it lives.
class SignalGuard {
public:
  SignalGuard() : old_int_(std::signal(SIGINT, on_signal)), old_term_(std::signal(SIGTERM, on_signal)) {
    interrupt = 0;
  }
  ~SignalGuard() {
    std::signal(SIGINT, old_int_);
    std::signal(SIGTERM, old_term_);
  }
  SignalGuard(const SignalGuard&) = delete;
  SignalGuard& operator=(const SignalGuard&) = delete;

private:
  void (*old_int_)(int);
  void (*old_term_)(int);
};

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

template <class T> T percentile(std::vector<T> values, double share) {
  if (values.empty()) return T{};
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

/// One run, from its scene to its record.
class Run {
public:
  Run(const RunOptions& options, Scene scene);
  ExitCode go();

private:
  void open_outputs();
  bool steps_of_frame(); ///< false: interrupted
  void take_rows(double milliseconds);
  void write_frame(unsigned frame);
  void watch_contacts(Progress& progress);
  void check_finite(const StepStatistics& row) const;
  nlohmann::json record(const std::string& status) const;
  void finish(const std::string& status);

  const RunOptions& options_;
  Scene scene_;
  std::filesystem::path folder_;
  Model model_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<RunWriter> writer_;
  std::unique_ptr<StatisticsWriter> statistics_;
  std::unique_ptr<Film> film_;
  std::vector<std::string> components_;
  unsigned frames_ = 0, frames_written_ = 0, steps_per_frame_ = 1;
  std::uint32_t contacts_dropped_ = 0; ///< the most at a frame
  std::vector<StepStatistics> rows_;
  std::vector<double> step_ms_;
  std::vector<std::vector<double>> component_ms_;
  Clock::time_point start_ = Clock::now();
};

Run::Run(const RunOptions& options, Scene scene) : options_(options), scene_(std::move(scene)) {
  if (!options.solver.empty()) scene_.solver.method = options.solver;
  folder_ = options.out.empty() ? std::filesystem::path("out") / scene_.name : options.out;
  model_ = assemble(scene_);
  device_ = open_device(options.device, [](const std::string& line) { fmt::print(stderr, "{}\n", line); });
  PlanRequest request;
  request.frames = scene_.output.data || options.render;
  request.fields = scene_.output.fields;
  simulation_ = std::make_unique<Simulation>(*device_, scene_, model_, request);
  frames_ =
      options.frames.value_or(static_cast<unsigned>(std::lround(scene_.simulation.end * scene_.output.fps)));
  steps_per_frame_ = static_cast<unsigned>(std::lround(1 / scene_.output.fps / simulation_->time_step()));
  if (!options.render) return;
  try {
    renderer_ = make_renderer(*device_, scene_, model_, field_label(scene_.render.color));
  } catch (const Error& error) {
    if (error.code() != ExitCode::no_device) throw;
    throw Error(error.code(),
                fmt::format("{}. Pictures need one, software will do; --no-render makes none", error.what()));
  }
}

void Run::open_outputs() {
  prepare_output_folder(folder_);
  if (renderer_) std::filesystem::create_directories(folder_ / "frames");
  const Plan& plan = simulation_->plan();
  components_ = {"motion", "elasticity", "solver"}; // as step.cpp books them
  for (const char* component : {"boundaries", "contacts", "momentum", "statistics"})
    if (std::find(plan.used.begin(), plan.used.end(), component) != plan.used.end())
      components_.emplace_back(component);
  component_ms_.resize(components_.size());
  statistics_ = std::make_unique<StatisticsWriter>(folder_ / "statistics.csv", components_);
  if (scene_.output.data) {
    std::vector<BodyOutput> blocks;
    for (const BodyModel& body : model_.bodies) {
      BodyOutput block{body.name, BodyOutput::Kind::particles, body.count, {}, {}};
      for (const std::string& field : scene_.output.fields)
        block.fields.push_back({field, field == "velocity" || field == "displacement" ? 3u : 1u});
      blocks.push_back(block);
    }
    if (plan.surfaces)
      for (const BodyModel& body : model_.bodies)
        if (body.surface)
          blocks.push_back({body.name + "_surface",
                            BodyOutput::Kind::surface,
                            body.surface->vertices.size(),
                            body.surface->triangles,
                            {}});
    writer_ = std::make_unique<RunWriter>(folder_, blocks, scene_.output.fps);
  }
  if (options_.video && renderer_)
    film_ = std::make_unique<Film>(folder_ / "film.mp4", scene_.render.size[0], scene_.render.size[1],
                                   scene_.output.fps);
}

void Run::check_finite(const StepStatistics& row) const {
  if (row.not_finite == 0) return;
  const std::vector<Vector3> positions = simulation_->positions();
  std::string where = "a particle";
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (!positions[i].allFinite()) {
      const BodyModel& body = model_.bodies[model_.body[i]];
      where = fmt::format("particle {} of body '{}'", model_.id[i], body.name);
      break;
    }
  throw Error(
      ExitCode::diverged,
      fmt::format("step {} (t = {:.6g} s): {} and {} others are no longer finite; frames up to {} are in {}. "
                  "Use a smaller time step or more iterations",
                  row.step, row.time, where, row.not_finite - 1, frames_written_ ? frames_written_ - 1 : 0,
                  folder_.string()));
}

void Run::take_rows(double milliseconds) {
  std::vector<double> spent(components_.size(), 0.0);
  for (const Timing& timing : device_->take_timings())
    for (std::size_t c = 0; c < components_.size(); ++c)
      if (components_[c] == timing.component) spent[c] += timing.milliseconds;
  for (const StepStatistics& row : simulation_->take_statistics()) {
    statistics_->append({row.step,
                         row.time,
                         row.iterations,
                         row.residual,
                         row.kinetic_energy,
                         row.elastic_energy,
                         {row.momentum.x(), row.momentum.y(), row.momentum.z()},
                         milliseconds,
                         spent});
    rows_.push_back(row);
    check_finite(row);
  }
  step_ms_.push_back(milliseconds);
  for (std::size_t c = 0; c < components_.size(); ++c) component_ms_[c].push_back(spent[c]);
}

bool Run::steps_of_frame() {
  for (unsigned s = 0; s < steps_per_frame_; ++s) {
    if (interrupt) return false;
    const auto start = Clock::now();
    simulation_->step();
    device_->finish();
    take_rows(milliseconds_since(start));
  }
  return true;
}

void Run::write_frame(unsigned frame) {
  FrameOutput* output = simulation_->frame();
  if (!output) return;
  output->update();
  if (writer_) {
    const std::vector<Real4<double>> particles = device_->download_real4(output->particle());
    std::vector<float> positions(3 * particles.size()), vertices;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      positions[3 * i] = static_cast<float>(particles[i].x);
      positions[3 * i + 1] = static_cast<float>(particles[i].y);
      positions[3 * i + 2] = static_cast<float>(particles[i].z);
    }
    std::vector<std::vector<float>> fields;
    std::vector<unsigned> widths;
    for (const std::string& name : scene_.output.fields) {
      unsigned width = 1;
      fields.push_back(output->field(name, width));
      widths.push_back(width);
    }
    std::vector<BodyFrame> blocks;
    for (const BodyModel& body : model_.bodies) {
      BodyFrame block{std::span(positions).subspan(3 * std::size_t{body.first}, 3 * std::size_t{body.count}),
                      {}};
      for (std::size_t f = 0; f < fields.size(); ++f)
        block.fields.push_back(std::span<const float>(fields[f]).subspan(
            widths[f] * std::size_t{body.first}, widths[f] * std::size_t{body.count}));
      blocks.push_back(block);
    }
    if (output->vertex()) {
      for (const Real4<double>& v : device_->download_real4(output->vertex()))
        vertices.insert(vertices.end(),
                        {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
      const std::vector<std::uint32_t>& first = output->skin().first;
      for (std::size_t b = 0; b < model_.bodies.size(); ++b)
        if (model_.bodies[b].surface)
          blocks.push_back({std::span<const float>(vertices).subspan(
                                3 * std::size_t{first[b]}, 3 * std::size_t{first[b + 1] - first[b]}),
                            {}});
    }
    writer_->append(frame, blocks);
  }
  if (renderer_) {
    const Image image =
        renderer_->draw(*device_, {output->particle(), output->vertex(), simulation_->time()});
    write_png(image, folder_ / "frames" / fmt::format("{:06}.png", frame));
    if (film_) film_->add(image);
  }
  frames_written_ = frame + 1;
}

// Says once that contacts are dropped, and keeps the most.
void Run::watch_contacts(Progress& progress) {
  const std::uint32_t dropped = simulation_->contacts_dropped();
  if (dropped > 0 && contacts_dropped_ == 0)
    progress.say(
        fmt::format("warning: {} contacts found no room (t = {:.4g} s) and do not act: more particles "
                    "touch one than a body can pack; look for bodies that overlap, or for a body that "
                    "is crushed",
                    dropped, simulation_->time()));
  contacts_dropped_ = std::max(contacts_dropped_, dropped);
}

nlohmann::json Run::record(const std::string& status) const {
  std::vector<unsigned> iterations;
  std::vector<double> residuals;
  for (const StepStatistics& row : rows_) {
    iterations.push_back(row.iterations);
    residuals.push_back(row.residual);
  }
  nlohmann::json components = nlohmann::json::object();
  for (std::size_t c = 0; c < components_.size(); ++c)
    components[components_[c]] = percentile(component_ms_[c], 0.5);
  const DeviceInfo& info = device_->info();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  nlohmann::json j;
  j["status"] = status;
  j["version"] = PLIANT_VERSION;
  j["device"] = {{"backend", info.backend},
                 {"name", info.name},
                 {"driver", info.driver},
                 {"software", info.software},
                 {"precision", info.precision == Precision::double_precision ? "double" : "float"},
                 {"threads", info.threads}};
  j["particles"] = model_.count();
  j["bonds"] = model_.bonds.count();
  j["steps"] = simulation_->steps();
  j["frames"] = frames_written_;
  j["time"] = simulation_->time();
  j["time_step"] = simulation_->time_step();
  j["stiffness_number"] = simulation_->stiffness_number();
  j["wall_seconds"] = milliseconds_since(start_) / 1000;
  j["step_ms"] = {
      {"median", percentile(step_ms_, 0.5)}, {"p95", percentile(step_ms_, 0.95)}, {"components", components}};
  j["iterations"] = {{"median", percentile(iterations, 0.5)}, {"max", percentile(iterations, 1.0)}};
  j["residual"] = {{"median", percentile(residuals, 0.5)}, {"max", percentile(residuals, 1.0)}};
  j["peak_bytes"] = {{"host", static_cast<std::int64_t>(usage.ru_maxrss) * 1024},
                     {"device", device_->bytes_peak()}};
  j["contacts_dropped"] = std::max(contacts_dropped_, simulation_->contacts_dropped());
  j["hash"] = simulation_->hash();
  j["warnings"] = model_.warnings;
  j["scene"] = scene_to_json(scene_);
  return j;
}

void Run::finish(const std::string& status) {
  if (film_) film_->close();
  if (writer_) writer_->close();
  const std::string text = record(status).dump(2) + "\n";
  write_text_file(folder_ / "run.json", text);
  if (options_.json == "-")
    std::cout << text << std::flush;
  else if (!options_.json.empty())
    write_text_file(options_.json, text);
}

ExitCode Run::go() {
  for (const std::string& warning : model_.warnings) fmt::print(stderr, "warning: {}\n", warning);
  const double asked = scene_.simulation.time_step, taken = simulation_->time_step();
  if (std::abs(asked - taken) > 1e-9 * asked)
    fmt::print(stderr, "time step {:.6g} s instead of {:.6g} s: {} whole steps make a frame\n", taken, asked,
               steps_per_frame_);
  open_outputs();
  simulation_->measure(true);
  const SignalGuard guard;
  Progress progress(options_.progress, frames_);
  std::string status = "finished";
  try {
    write_frame(0);
    for (unsigned frame = 1; frame <= frames_; ++frame) {
      if (!steps_of_frame()) {
        status = "interrupted";
        break;
      }
      write_frame(frame);
      watch_contacts(progress);
      const StepStatistics& row = rows_.back();
      progress.frame(frame, row.time, row.reason == StopReason::floor ? 0 : row.residual, row.iterations);
    }
  } catch (const Error& error) {
    if (error.code() == ExitCode::diverged) finish("diverged");
    if (error.code() == ExitCode::input_output && frames_written_ > 0)
      throw Error(error.code(), fmt::format("{}; frames 0 to {} in {} are intact", error.what(),
                                            frames_written_ - 1, folder_.string()));
    throw;
  }
  finish(status);
  if (status == "interrupted") {
    progress.say(fmt::format("stopped after frame {}; what was computed is in {}", frames_written_ - 1,
                             folder_.string()));
    return static_cast<ExitCode>(128 + interrupt);
  }
  const auto capped = std::count_if(rows_.begin(), rows_.end(),
                                    [](const StepStatistics& row) { return row.reason == StopReason::cap; });
  if (capped > 0)
    progress.say(fmt::format(
        "{} of {} steps reached the cap of {} iterations before the tolerance: the result is softer "
        "and more damped than the material; raise solver.iterations",
        capped, rows_.size(), scene_.solver.iterations));
  return ExitCode::good;
}

} // namespace

ExitCode run_scene(const RunOptions& options) {
  Run run(options, read_scene(options.scene, options.overrides));
  return run.go();
}

} // namespace pliant
