// The command `run`: the loop over frames, and the record of what came out.
#include "engine/report/run.h"

#include "engine/io/folder.h"
#include "engine/report/progress.h"
#include "engine/report/run_outputs.h"
#include "engine/scene/scene_json.h"
#include "engine/scene/scene_parse.h"
#include "engine/solver/fluid.h"
#include "engine/solver/guarded_run.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fmt/format.h>
#include <iostream>
#include <map>
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
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

std::string stop_name(StopReason reason) {
  switch (reason) {
  case StopReason::tolerance:
    return "tolerance";
  case StopReason::floor:
    return "floor";
  case StopReason::stalled:
    return "stalled";
  case StopReason::none:
  case StopReason::cap:
    break;
  }
  return "cap";
}

/// One run, from its scene to its record.
class Run {
public:
  Run(const RunOptions& options, Scene scene);
  ExitCode go();

private:
  bool start(); ///< opens or resumes; false: it is finished already
  void load(const Checkpoint& checkpoint);
  bool run_on(Progress& progress); ///< false: interrupted
  bool stretch(Progress& progress);
  void checkpoint();
  void watch_contacts(Progress& progress);
  nlohmann::json record(const std::string& status) const;
  nlohmann::json fluid_record() const;
  void print(const std::string& text) const;
  void finish(const std::string& status);
  void say(const std::string& line) const { fmt::print(stderr, "{}\n", line); }
  std::uint64_t last_step() const { return std::uint64_t{frames_} * steps_per_frame_; }

  const RunOptions& options_;
  Scene scene_;
  Model model_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<GuardedRun> guard_;
  std::unique_ptr<RunOutputs> outputs_;
  CheckpointIdentity identity_;
  unsigned frames_ = 0, steps_per_frame_ = 1;
  std::uint32_t contacts_dropped_ = 0;      ///< the most at a frame
  std::optional<std::uint64_t> saved_step_; ///< of the last checkpoint
  double earlier_seconds_ = 0;              ///< of the run before it was resumed
  Clock::time_point start_ = Clock::now();
};

Run::Run(const RunOptions& options, Scene scene) : options_(options), scene_(std::move(scene)) {
  if (!options.solver.empty()) scene_.solver.method = options.solver;
  model_ = assemble(scene_);
  device_ = open_device(options.device, [this](const std::string& line) { say(line); });
  PlanRequest request;
  request.divergence = true;
  request.frames = scene_.output.data || options.render;
  request.fields = scene_.output.fields;
  simulation_ = std::make_unique<Simulation>(*device_, scene_, model_, request);
  frames_ =
      options.frames.value_or(static_cast<unsigned>(std::lround(scene_.simulation.end * scene_.output.fps)));
  steps_per_frame_ = static_cast<unsigned>(std::lround(1 / scene_.output.fps / simulation_->time_step()));
  const DeviceInfo& info = device_->info();
  identity_ = {scene_fingerprint(scene_, model_),
               build_fingerprint(),
               info.backend,
               info.name,
               info.driver,
               info.precision == Precision::double_precision ? "double" : "float"};
  const std::filesystem::path folder =
      options.out.empty() ? std::filesystem::path("out") / scene_.name : options.out;
  outputs_ =
      std::make_unique<RunOutputs>(folder, scene_, model_, *simulation_, options.render, options.video);
}

void Run::load(const Checkpoint& checkpoint) {
  simulation_->load(checkpoint.state);
  outputs_->resume(checkpoint.progress);
  guard_ = std::make_unique<GuardedRun>(*simulation_, scene_, model_, steps_per_frame_);
  guard_->count_from(checkpoint.progress.retries, checkpoint.progress.divided_steps);
  drop_checkpoints_after(outputs_->folder(), checkpoint.state.step);
  earlier_seconds_ = checkpoint.progress.wall_seconds;
  saved_step_ = checkpoint.state.step;
}

bool Run::start() {
  const std::filesystem::path& folder = outputs_->folder();
  if (options_.resume) {
    const std::optional<Checkpoint> found =
        find_checkpoint(folder, identity_, [this](const std::string& line) { say("warning: " + line); });
    std::string old, status;
    if (std::filesystem::exists(folder / "run.json")) {
      old = read_text_file(folder / "run.json");
      const nlohmann::json j = nlohmann::json::parse(old, nullptr, false);
      if (j.is_object()) status = j.value("status", "");
    }
    if (status == "finished" && (!found || found->state.step >= last_step())) {
      say(fmt::format("{} is finished: there is nothing to resume", folder.string()));
      print(old);
      return false;
    }
    if (found) {
      say(fmt::format("resuming {} at step {}", folder.string(), found->state.step));
      load(*found);
      return true;
    }
    say(fmt::format("{} has no checkpoint: starting anew", folder.string()));
    clear_run(folder);
  }
  outputs_->open();
  guard_ = std::make_unique<GuardedRun>(*simulation_, scene_, model_, steps_per_frame_);
  outputs_->write_frame(0);
  return true;
}

void Run::checkpoint() {
  if (saved_step_ == simulation_->steps()) return;
  Checkpoint checkpoint{identity_, outputs_->progress(), simulation_->save()};
  checkpoint.progress.wall_seconds = earlier_seconds_ + milliseconds_since(start_) / 1000;
  checkpoint.progress.retries = guard_->retries();
  checkpoint.progress.divided_steps = guard_->divided_steps();
  write_checkpoint(outputs_->folder(), checkpoint);
  saved_step_ = simulation_->steps();
}

bool Run::stretch(Progress& progress) {
  const std::vector<std::string>& components = outputs_->components();
  std::vector<double> total;
  std::vector<std::vector<double>> spent;
  auto began = Clock::now();
  GuardedCalls calls;
  calls.begin = [&](unsigned) {
    total.clear();
    spent.clear();
  };
  calls.before_step = [&] {
    if (interrupt) return false;
    if (options_.before_step) options_.before_step(*simulation_);
    began = Clock::now();
    return true;
  };
  calls.after_step = [&] {
    device_->finish();
    total.push_back(milliseconds_since(began));
    spent.emplace_back(components.size(), 0.0);
    for (const Timing& timing : device_->take_timings())
      for (std::size_t c = 0; c < components.size(); ++c)
        if (components[c] == timing.component) spent.back()[c] += timing.milliseconds;
  };
  calls.say = [&](const std::string& line) { progress.say(line); };
  const std::vector<StepStatistics> rows = guard_->advance(last_step(), calls);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const StepStatistics& row = rows[k];
    outputs_->append(
        {row.step,
         row.time,
         row.iterations,
         row.residual,
         stop_name(row.reason),
         row.kinetic_energy,
         row.elastic_energy,
         {row.momentum.x(), row.momentum.y(), row.momentum.z()},
         total[k],
         spent[k],
         simulation_->plan().failure
             ? std::optional(std::array{static_cast<double>(row.broken_bonds), row.fracture_energy})
             : std::nullopt,
         simulation_->plan().method.potential
             ? std::optional(std::array{row.energy_error, static_cast<double>(row.energy_rises)})
             : std::nullopt,
         simulation_->plan().plastic || simulation_->plan().fluid_flow
             ? std::optional(std::array{static_cast<double>(row.yielding), row.plastic_work,
                                        row.plastic_strain, row.plastic_volume,
                                        static_cast<double>(row.plastic_rounds), row.yield_excess})
             : std::nullopt,
         simulation_->plan().fluid
             ? std::optional(std::array{row.density_error, row.largest_density_error, row.density_slope,
                                        static_cast<double>(row.removed)})
             : std::nullopt,
         simulation_->plan().fluid_forces
             ? std::optional(std::array{static_cast<double>(row.viscosity_iterations), row.viscosity_residual,
                                        row.unevenness})
             : std::nullopt,
         simulation_->plan().fluid_sources
             ? std::optional(std::array{static_cast<double>(row.emitted), static_cast<double>(row.sunk),
                                        static_cast<double>(row.present)})
             : std::nullopt});
  }
  return !rows.empty() || guard_->full();
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

bool Run::run_on(Progress& progress) {
  while (simulation_->steps() < last_step()) {
    if (!stretch(progress)) return false;
    if (guard_->full()) throw Error(*guard_->full());
    if (simulation_->steps() % steps_per_frame_ != 0) continue;
    const auto frame = static_cast<unsigned>(simulation_->steps() / steps_per_frame_);
    outputs_->write_frame(frame);
    watch_contacts(progress);
    const StatisticsRow& row = outputs_->rows().back();
    progress.frame(frame, row.time, row.stopped == "floor" || row.stopped == "stalled" ? 0 : row.residual,
                   static_cast<unsigned>(row.iterations));
    if (scene_.output.checkpoint_every > 0 && frame % scene_.output.checkpoint_every == 0) checkpoint();
  }
  return true;
}

nlohmann::json Run::record(const std::string& status) const {
  std::vector<std::uint64_t> iterations;
  std::vector<double> residuals, step_ms;
  const std::vector<std::string>& names = outputs_->components();
  std::vector<std::vector<double>> component_ms(names.size());
  std::map<std::string, std::uint64_t> stopped{{"tolerance", 0}, {"floor", 0}, {"cap", 0}, {"stalled", 0}};
  for (const StatisticsRow& row : outputs_->rows()) {
    iterations.push_back(row.iterations);
    residuals.push_back(row.residual);
    step_ms.push_back(row.ms_total);
    for (std::size_t c = 0; c < names.size(); ++c) component_ms[c].push_back(row.ms_components[c]);
    ++stopped[row.stopped];
  }
  nlohmann::json components = nlohmann::json::object();
  for (std::size_t c = 0; c < names.size(); ++c) components[names[c]] = percentile(component_ms[c], 0.5);
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
  j["frames"] = outputs_->frames();
  j["time"] = simulation_->time();
  j["time_step"] = simulation_->time_step();
  j["stiffness_number"] = simulation_->stiffness_number();
  j["wall_seconds"] = earlier_seconds_ + milliseconds_since(start_) / 1000;
  j["step_ms"] = {
      {"median", percentile(step_ms, 0.5)}, {"p95", percentile(step_ms, 0.95)}, {"components", components}};
  j["iterations"] = {{"median", percentile(iterations, 0.5)}, {"max", percentile(iterations, 1.0)}};
  j["residual"] = {{"median", percentile(residuals, 0.5)}, {"max", percentile(residuals, 1.0)}};
  j["stopped"] = stopped;
  j["retries"] = guard_->retries();
  j["divided_steps"] = guard_->divided_steps();
  j["peak_bytes"] = {{"host", static_cast<std::int64_t>(usage.ru_maxrss) * 1024},
                     {"device", device_->bytes_peak()}};
  if (simulation_->plan().fluid) j["fluid"] = fluid_record();
  const Method& method = simulation_->plan().method;
  j["solver"] = {{"method", method.name},
                 {"preconditioner", method.preconditioner},
                 {"reason", method.reason},
                 {"stiffness_number", method.stiffness_number}};
  j["contacts_dropped"] = std::max(contacts_dropped_, simulation_->contacts_dropped());
  j["hash"] = simulation_->hash();
  j["warnings"] = model_.warnings;
  j["scene"] = scene_to_json(scene_);
  return j;
}

nlohmann::json Run::fluid_record() const {
  std::vector<double> mean, largest, iterations, residual, unevenness;
  double removed = 0;
  for (const StatisticsRow& row : outputs_->rows()) {
    if (!row.fluid) continue;
    mean.push_back((*row.fluid)[0]);
    largest.push_back((*row.fluid)[1]);
    removed = (*row.fluid)[3];
    if (!row.forces) continue;
    iterations.push_back((*row.forces)[0]);
    residual.push_back((*row.forces)[1]);
    unevenness.push_back((*row.forces)[2]);
  }
  nlohmann::json j = {
      {"density_error", {{"median", percentile(mean, 0.5)}, {"max", percentile(mean, 1.0)}}},
      {"largest_density_error", {{"median", percentile(largest, 0.5)}, {"max", percentile(largest, 1.0)}}},
      {"removed", removed}};
  if (const FluidFlow* flow = simulation_->fluid()->flow()) {
    const StatisticsRow* last = outputs_->rows().empty() ? nullptr : &outputs_->rows().back();
    if (last && last->flow)
      j["emitted"] = (*last->flow)[0], j["sunk"] = (*last->flow)[1], j["present"] = (*last->flow)[2];
    for (std::size_t e = 0; e < scene_.emitters.size(); ++e)
      j["emitters"][scene_.emitters[e].name] = {{"emitted", flow->emitted_by(e)},
                                                {"ended_by_capacity", flow->ended(e)}};
    const std::vector<std::uint32_t> sunk = simulation_->fluid()->flow()->sunk_by();
    for (std::size_t s = 0; s < sunk.size(); ++s) j["sinks"][scene_.sinks[s].name] = sunk[s];
  }
  const auto range = [](const std::vector<double>& values) {
    return nlohmann::json{{"median", percentile(values, 0.5)}, {"max", percentile(values, 1.0)}};
  };
  if (iterations.empty()) return j;
  j["viscosity"] = {{"iterations", range(iterations)}, {"residual", range(residual)}};
  j["unevenness"] = range(unevenness);
  return j;
}

void Run::print(const std::string& text) const {
  if (options_.json == "-")
    std::cout << text << std::flush;
  else if (!options_.json.empty())
    write_text_file(options_.json, text);
}

void Run::finish(const std::string& status) {
  checkpoint();
  outputs_->close();
  const std::string text = record(status).dump(2) + "\n";
  write_text_file(outputs_->folder() / "run.json", text);
  print(text);
}

ExitCode Run::go() {
  for (const std::string& warning : model_.warnings) say("warning: " + warning);
  const double asked = scene_.simulation.time_step, taken = simulation_->time_step();
  if (std::abs(asked - taken) > 1e-9 * asked)
    say(fmt::format("time step {:.6g} s instead of {:.6g} s: {} whole steps make a frame", taken, asked,
                    steps_per_frame_));
  const Method& method = simulation_->plan().method;
  if (!method.reason.empty())
    say(fmt::format("solver auto: {}{}{}, because {}", method.name, method.preconditioner.empty() ? "" : ", ",
                    method.preconditioner, method.reason));
  const SignalGuard guard;
  if (!start()) return ExitCode::good;
  simulation_->measure(true);
  Progress progress(options_.progress, frames_,
                    static_cast<unsigned>(simulation_->steps() / steps_per_frame_));
  bool whole = false;
  try {
    whole = run_on(progress);
  } catch (const Error& error) {
    if (error.code() == ExitCode::diverged) finish("diverged");
    if (guard_->full()) {
      finish("full");
      throw Error(error.code(),
                  fmt::format("{}; what was computed up to step {} (t = {:.6g} s) is in {}", error.what(),
                              simulation_->steps(), simulation_->time(), outputs_->folder().string()));
    }
    if (error.code() == ExitCode::input_output && outputs_->frames() > 0)
      throw Error(error.code(), fmt::format("{}; frames 0 to {} in {} are intact", error.what(),
                                            outputs_->frames() - 1, outputs_->folder().string()));
    throw;
  }
  finish(whole ? "finished" : "interrupted");
  if (!whole) {
    progress.say(fmt::format("stopped at step {}, after frame {}; what was computed is in {}, and --resume "
                             "goes on from there",
                             simulation_->steps(), outputs_->frames() - 1, outputs_->folder().string()));
    return static_cast<ExitCode>(128 + interrupt);
  }
  const std::vector<StatisticsRow>& rows = outputs_->rows();
  if (const std::size_t removed =
          rows.empty() || !rows.back().fluid ? 0 : std::size_t((*rows.back().fluid)[3]))
    progress.say(fmt::format("{} particles left the domain and were removed", removed));
  if (!rows.empty() && rows.back().flow) {
    for (std::size_t e = 0; e < scene_.emitters.size(); ++e)
      if (simulation_->fluid()->flow()->ended(e))
        progress.say(fmt::format("emitter '{}' ended after {} particles: the scene was full",
                                 scene_.emitters[e].name, simulation_->fluid()->flow()->emitted_by(e)));
    progress.say(fmt::format("{} particles were emitted, {} ran into sinks, {} are there",
                             (*rows.back().flow)[0], (*rows.back().flow)[1], (*rows.back().flow)[2]));
  }
  const auto capped =
      simulation_->plan().fluid ? 0 : std::count_if(rows.begin(), rows.end(), [](const StatisticsRow& row) {
        return row.stopped == "cap";
      });
  if (capped > 0)
    progress.say(fmt::format(
        "{} of {} steps reached the cap of {} iterations before the tolerance: the result is softer "
        "and more damped than the material; raise solver.iterations",
        capped, rows.size(), scene_.solver.iterations));
  return ExitCode::good;
}

} // namespace

ExitCode run_scene(const RunOptions& options) {
  Run run(options, read_scene(options.scene, options.overrides));
  return run.go();
}

} // namespace pliant
