// The benchmark: bodies and scenes, what is measured of them, tables and JSON.
#include "engine/report/bench.h"

#include "engine/core/error.h"
#include "engine/model/model.h"
#include "engine/report/bench_ceilings.h"
#include "engine/report/bench_device.h"
#include "engine/scene/mesh.h"
#include "engine/solver/simulation.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <ostream>

namespace pliant {

namespace {

using Json = nlohmann::ordered_json;

constexpr double limit_seconds = 20; ///< of an entry
constexpr const char* all_sizes[] = {"beam", "bunny", "box"};

/// One scene; a fixed number of iterations where the time of one is the question.
struct Entry {
  Scene scene;
  Model model;
};

Entry make_entry(const std::string& size) {
  Entry entry;
  Scene& scene = entry.scene;
  scene.name = size;
  Material rubber;
  rubber.name = "rubber";
  scene.materials = {rubber};
  scene.output.fps = 60;
  scene.simulation.time_step = 1.0 / 60;
  Body body;
  body.name = size;
  body.material = rubber.name;
  if (size == "beam") { // a cantilever, solved to the default tolerance
    scene.simulation.spacing = 0.02;
    body.shape.size = {0.6, 0.2, 0.2};
    Condition fixed;
    fixed.region.at = {-0.3, 0, 0};
    fixed.region.size = {0.06, 1, 1};
    body.conditions.push_back(fixed);
  } else if (size == "bunny") { // on the ground
    constexpr double particles = 25000;
    double volume = 0;
    try {
      const MeshReport report = examine(read_mesh(find_mesh("bunny00.off", {})));
      const double scale = 1 / (report.high - report.low).maxCoeff();
      body.shape.kind = Shape::Kind::mesh;
      body.shape.mesh = "bunny00.off";
      body.shape.fit = 1.0;
      body.shape.place = body.shape.at = {0, 0.6, 0};
      volume = std::abs(report.volume) * scale * scale * scale;
    } catch (const Error&) { // no such mesh here: a ball of as many particles
      body.shape.kind = Shape::Kind::sphere;
      body.shape.radius = 0.5;
      body.shape.at = {0, 0.6, 0};
      volume = 4.0 / 3 * 3.14159265358979 * 0.125;
    }
    scene.simulation.spacing = std::cbrt(volume / particles);
    Boundary ground;
    ground.name = "ground";
    ground.shape.kind = Shape::Kind::plane;
    scene.boundaries.push_back(ground);
    scene.solver.method = "chebyshev";
    scene.solver.iterations = 64;
    scene.solver.tolerance = 0;
  } else { // 100 x 100 x 100, in free fall
    scene.simulation.spacing = 0.01;
    scene.solver.method = "chebyshev";
    scene.solver.iterations = 16;
    scene.solver.tolerance = 0;
  }
  // Pulled, so that no solve ends early: a body at rest or in free flight needs no iterations.
  if (size != "beam") body.deform = Vector3(1.1, 0.95, 1).asDiagonal();
  scene.bodies = {body};
  entry.model = assemble(scene);
  return entry;
}

struct Spread {
  double median = 0, relative = 0; ///< half the distance of the quartiles over the median
};
Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const double median = values[values.size() / 2];
  const double quartiles = values[values.size() * 3 / 4] - values[values.size() / 4];
  return {median, median > 0 ? quartiles / 2 / median : 0};
}

std::unique_ptr<Device> open(const std::string& backend) {
  DeviceRequest request;
  request.backend = backend;
  return open_device(request);
}

class Bench {
public:
  Bench(const BenchOptions& options, std::ostream& out) : options_(options), out_(out) {
    result_["ceilings"] = Json::object();
    result_["kernels"] = result_["scenes"] = Json::array();
  }

  void ceilings(const std::string& backend) {
    const std::unique_ptr<Device> device = open(backend);
    const Ceilings c = ceilings_[backend] = measure_ceilings(*device);
    out_ << fmt::format("\n{}: {}, {}{}\n", backend, device->info().name, device->info().driver,
                        device->info().software ? " (software)" : "");
    Json& json = result_["ceilings"][backend];
    json["name"] = device->info().name;
    if (c.copy > 0) {
      out_ << fmt::format("  ceilings: copy {:.1f} GB/s\n", c.copy);
      json["copy_gb_per_s"] = c.copy;
      return;
    }
    out_ << fmt::format(
        "  ceilings, {} threads: read memory {:.1f}, L3 {:.1f}, L2 {:.1f} GB/s; multiply-add {:.1f} "
        "GFLOP/s in 32 bits\n",
        device->info().threads, c.read_memory, c.read_l3, c.read_l2, c.fma);
    json["threads"] = device->info().threads;
    json["read_memory_gb_per_s"] = c.read_memory;
    json["read_l3_gb_per_s"] = c.read_l3;
    json["read_l2_gb_per_s"] = c.read_l2;
    json["fma_gflop_per_s"] = c.fma;
  }

  void kernels(const std::string& backend, const Entry& entry) {
    const std::unique_ptr<Device> device = open(backend);
    BenchDevice watched(*device, limit_seconds);
    guarded(backend, entry, [&] {
      Simulation simulation(watched, entry.scene, entry.model);
      watched.restart();
      simulation.step(); // warm-up
      watched.time_kernels();
      for (int r = 0; r < repeats(); ++r) simulation.step();
    });
    if (watched.samples().empty()) return;
    const std::size_t particles = entry.model.count(), bonds = entry.model.bonds.count();
    out_ << fmt::format(
        "  kernels on {}: {} particles, {} bonds; bytes of the buffers declared\n    {:<20}{:>11}{:>8}"
        "{:>9}{:>9}{:>10}\n",
        entry.scene.name, particles, bonds, "kernel", "ms", "+-", "ns/bond", "GB/s", "roofline");
    for (const auto& [kernel, samples] : watched.samples()) {
      const Spread time = spread(samples.milliseconds);
      const double rate = samples.bytes / (time.median * 1e6);
      const double share = rate / ceilings_[backend].bandwidth(samples.bytes);
      const double per_bond = time.median * 1e6 / static_cast<double>(std::max<std::size_t>(bonds, 1));
      out_ << fmt::format("    {:<20}{:>11.4f}{:>7.0f}%{:>9}{:>9.1f}{:>9.0f}%\n", kernel, time.median,
                          100 * time.relative, samples.bonds ? fmt::format("{:.3f}", per_bond) : "-", rate,
                          100 * share);
      result_["kernels"].push_back({{"kernel", kernel},
                                    {"backend", backend},
                                    {"particles", particles},
                                    {"ms", time.median},
                                    {"ns_per_bond", samples.bonds ? Json(per_bond) : Json()},
                                    {"gb_per_s", rate},
                                    {"roofline_share", share},
                                    {"spread", time.relative},
                                    {"dispatches", samples.milliseconds.size()}});
    }
  }

  void scene(const std::string& backend, const Entry& entry) {
    const std::unique_ptr<Device> device = open(backend);
    BenchDevice watched(*device, limit_seconds);
    std::vector<double> steps, iterations;
    Json row{{"scene", entry.scene.name}, {"backend", backend}, {"particles", entry.model.count()}};
    const bool stopped = guarded(backend, entry, [&] {
      Simulation simulation(watched, entry.scene, entry.model);
      const Precision precision = device->info().precision;
      row["bytes_per_bond"] = simulation.plan().bytes_per_bond(precision);
      row["bytes_per_particle"] = simulation.plan().bytes_per_particle(precision);
      watched.restart();
      for (int r = -1; r < repeats(); ++r) { // the first is warm-up
        const std::size_t before = watched.iterations();
        watched.finish();
        const double start = watched.elapsed();
        simulation.step();
        watched.finish();
        if (r < 0 && watched.elapsed() < limit_seconds / 2) continue;
        steps.push_back(1e3 * (watched.elapsed() - start));
        iterations.push_back(static_cast<double>(watched.iterations() - before));
      }
      row["hash"] = simulation.hash();
    });
    if (!row.contains("bytes_per_bond")) return; // it did not fit
    if (steps.empty()) {                         // not one step in time: what there is of it
      row["iterations"] = watched.iterations();
      row["ms_per_step"] = nullptr;
      row["ms_per_iteration"] =
          1e3 * watched.elapsed() / static_cast<double>(std::max<std::size_t>(watched.iterations(), 1));
    } else {
      const double step = spread(steps).median, count = spread(iterations).median;
      row["iterations"] = count;
      row["ms_per_step"] = step;
      row["ms_per_iteration"] = step / std::max(count, 1.0);
      row["spread"] = spread(steps).relative;
    }
    row["peak_bytes"] = device->bytes_peak();
    if (!row.contains("hash")) row["hash"] = nullptr;
    row["stopped"] = stopped;
    const auto number = [&](const char* key) { return row[key].is_number() ? row[key].get<double>() : NAN; };
    out_ << fmt::format(
        "  {:<6} {:>8} particles: {:>9.2f} ms a step, {:>5.0f} iterations of {:.3f} ms; peak {:.1f} MB, "
        "{:.1f} bytes a bond, {:.1f} a particle; hash {}\n",
        entry.scene.name, entry.model.count(), number("ms_per_step"), number("iterations"),
        number("ms_per_iteration"), number("peak_bytes") / 1e6, number("bytes_per_bond"),
        number("bytes_per_particle"), row["hash"].is_null() ? "-" : row["hash"].get<std::string>());
    result_["scenes"].push_back(row);
  }

  const Json& result() const { return result_; }

private:
  int repeats() const {
    return options_.quick ? std::min(options_.repeats, 2) : std::max(options_.repeats, 1);
  }

  /// True when the entry was stopped. What a device refuses is said and passed over.
  template <class Work> bool guarded(const std::string& backend, const Entry& entry, const Work& work) {
    try {
      work();
    } catch (const TimeUp&) {
      out_ << fmt::format("  {} on {}: stopped after {:.0f} s\n", entry.scene.name, backend, limit_seconds);
      return true;
    } catch (const Error& error) {
      if (error.code() != ExitCode::too_large) throw;
      out_ << fmt::format("  {} on {}: does not fit: {}\n", entry.scene.name, backend, error.what());
      return true;
    }
    return false;
  }

  const BenchOptions& options_;
  std::ostream& out_;
  Json result_;
  std::map<std::string, Ceilings> ceilings_;
};

std::vector<std::string> chosen_sizes(const BenchOptions& options) {
  for (const std::string& size : options.sizes)
    if (std::find(std::begin(all_sizes), std::end(all_sizes), size) == std::end(all_sizes))
      throw Error(ExitCode::usage, fmt::format("there is no size '{}': choose among beam, bunny, box", size));
  if (!options.sizes.empty()) return options.sizes;
  std::vector<std::string> sizes(std::begin(all_sizes), std::end(all_sizes));
  if (options.quick) sizes.pop_back();
  return sizes;
}

std::vector<std::string> chosen_backends(const BenchOptions& options) {
  if (!options.backends.empty()) return options.backends;
  std::vector<std::string> backends;
  for (const DeviceListing& listing : list_devices())
    if (listing.usable)
      backends.push_back(listing.backend == "gl" ? fmt::format("gl:{}", listing.index) : listing.backend);
  return backends;
}

Json read_baseline(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw Error(ExitCode::usage, fmt::format("the baseline '{}' cannot be read", file));
  Json json = Json::parse(in, nullptr, false);
  if (json.is_discarded() || !json.contains("kernels") || !json.contains("scenes"))
    throw Error(ExitCode::usage, fmt::format("'{}' is not the JSON of an earlier benchmark", file));
  return json;
}

/// Ratios of time, now over then: below 1 is faster.
void compare(const Json& now, const Json& then, std::ostream& out) {
  out << "\nagainst the baseline (time now / then):\n";
  const auto table = [&](const char* list, const char* name, const char* time) {
    for (const Json& a : now[list])
      for (const Json& b : then[list]) {
        if (a[name] != b.value(name, "") || a["backend"] != b.value("backend", "") ||
            a["particles"] != b.value("particles", 0) || !a[time].is_number() || !b[time].is_number())
          continue;
        out << fmt::format("  {:<20} {:<8} {:>8} particles {:>8.2f}\n", a[name].get<std::string>(),
                           a["backend"].get<std::string>(), a["particles"].get<std::size_t>(),
                           a[time].get<double>() / b[time].get<double>());
      }
  };
  table("kernels", "kernel", "ms");
  table("scenes", "scene", "ms_per_iteration");
}

} // namespace

int run_bench(const BenchOptions& options, std::ostream& out) {
  const std::vector<std::string> sizes = chosen_sizes(options), backends = chosen_backends(options);
  const Json baseline = options.baseline.empty() ? Json() : read_baseline(options.baseline);
  Bench bench(options, out);
  for (const std::string& backend : backends) bench.ceilings(backend);
  for (const std::string& size : sizes) {
    const Entry entry = make_entry(size); // once for all devices: a million particles take their time
    for (const std::string& backend : backends) {
      out << '\n' << backend << ", " << size << '\n';
      bench.scene(backend, entry);
      if (size != "beam") bench.kernels(backend, entry);
      out.flush();
    }
  }
  if (!baseline.is_null()) compare(bench.result(), baseline, out);
  if (options.json_file.empty()) return 0;
  std::ofstream file(options.json_file);
  file << bench.result().dump(2) << '\n';
  file.close();
  if (!file)
    throw Error(
        ExitCode::input_output,
        fmt::format("'{}' cannot be written: is the disk full, the folder there?", options.json_file));
  return 0;
}

} // namespace pliant
