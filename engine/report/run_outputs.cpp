// The files of a run's folder.
#include "engine/report/run_outputs.h"

#include "engine/core/error.h"
#include "engine/io/folder.h"
#include "engine/io/png.h"
#include "engine/scene/mesh.h"
#include "engine/scene/scene_json.h"
#include "engine/solver/frame.h"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace pliant {

namespace fs = std::filesystem;

namespace {

/// The number of a picture "000012.png"; nothing for any other name.
std::optional<unsigned long> picture_number(const fs::path& file) {
  const std::string stem = file.stem().string();
  if (file.extension() != ".png" || stem.size() < 6 || stem.size() > 10 ||
      stem.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  return std::stoul(stem);
}

bool draft(const fs::path& file) {
  return file.extension() == ".tmp";
}

/// The particles that are there, out of all.
class Rows {
public:
  Rows(const Model& model, const std::vector<bool>& present) : before_(model.count() + 1, 0) {
    for (std::size_t i = 0; i < model.count(); ++i)
      before_[i + 1] = before_[i] + (present.empty() || present[i] ? 1 : 0);
  }
  /// Of those, how many come before this one.
  std::size_t before(std::size_t particle) const { return before_[particle]; }
  /// Leaves the values of the others out, `width` each.
  void keep(std::vector<float>& values, std::size_t width) const {
    if (before_.back() + 1 == before_.size()) return;
    for (std::size_t i = 0; i + 1 < before_.size(); ++i)
      if (before_[i + 1] > before_[i])
        std::copy_n(values.begin() + std::ptrdiff_t(width * i), width,
                    values.begin() + std::ptrdiff_t(width * before_[i]));
    values.resize(width * before_.back());
  }

private:
  std::vector<std::size_t> before_;
};

fs::path picture(const fs::path& folder, unsigned frame) {
  return folder / "frames" / fmt::format("{:06}.png", frame);
}

} // namespace

RunOutputs::RunOutputs(fs::path folder, const Scene& scene, const Model& model, Simulation& simulation,
                       bool pictures, bool video)
    : folder_(std::move(folder)), scene_(scene), model_(model), simulation_(simulation), video_(video) {
  const Plan& plan = simulation.plan();
  if (!plan.fluid) components_ = {"motion", "elasticity", "solver"}; // as step.cpp books them
  for (const char* component :
       {"neighbours", "density", "viscosity", "redistribution", "emitters", "sinks", "preconditioner",
        "direct", "boundaries", "contacts", "momentum", "failure", "statistics", "divergence"})
    if (std::find(plan.used.begin(), plan.used.end(), component) != plan.used.end())
      components_.emplace_back(component);
  if (plan.fluid_bonds)
    for (const char* component : {"bonds", "elasticity"}) components_.emplace_back(component);
  if (plan.plastic || plan.fluid_flow) components_.emplace_back("plasticity");
  if (!pictures) return;
  try {
    renderer_ = make_renderer(simulation.device(), scene, model, field_label(scene.render.color));
  } catch (const Error& error) {
    if (error.code() != ExitCode::no_device) throw;
    throw Error(error.code(),
                fmt::format("{}. Pictures need one, software will do; --no-render makes none", error.what()));
  }
}

std::vector<BodyOutput> RunOutputs::blocks() const {
  std::vector<BodyOutput> blocks;
  for (const BodyModel& body : model_.bodies) {
    BodyOutput block{body.name, BodyOutput::Kind::particles, body.count, {}, {}, false};
    for (const std::string& field : scene_.output.fields)
      block.fields.push_back({field, field == "velocity" || field == "displacement" ? 3u : 1u});
    blocks.push_back(block);
  }
  if (simulation_.plan().surfaces)
    for (const BodyModel& body : model_.bodies)
      if (body.surface)
        blocks.push_back({body.name + "_surface",
                          BodyOutput::Kind::surface,
                          body.surface->vertices.size(),
                          body.surface->triangles,
                          {},
                          simulation_.frame()->torn() != nullptr});
  return blocks;
}

void RunOutputs::open() {
  prepare_output_folder(folder_);
  if (renderer_) fs::create_directories(folder_ / "frames");
  statistics_ = std::make_unique<StatisticsWriter>(folder_ / "statistics.csv", components_,
                                                   simulation_.plan().method.potential);
  if (scene_.output.data) writer_ = std::make_unique<RunWriter>(folder_, blocks(), scene_.output.fps);
  if (video_ && renderer_)
    film_ = std::make_unique<Film>(folder_ / "film.mp4", scene_.render.size[0], scene_.render.size[1],
                                   scene_.output.fps);
}

void RunOutputs::resume(const RunProgress& progress) {
  if (progress.pictures != (renderer_ != nullptr))
    throw Error(ExitCode::usage, progress.pictures
                                     ? "the run was started with pictures: resume it without --no-render"
                                     : "the run was started without pictures: resume it with --no-render");
  if (progress.data.has_value() != scene_.output.data)
    throw Error(ExitCode::input_output, "the checkpoint and the scene do not agree on run.vtkhdf");
  statistics_ =
      std::make_unique<StatisticsWriter>(folder_ / "statistics.csv", components_,
                                         simulation_.plan().method.potential, progress.statistics_bytes);
  rows_ = read_statistics(folder_ / "statistics.csv");
  if (progress.data)
    writer_ = std::make_unique<RunWriter>(folder_, blocks(), scene_.output.fps, *progress.data);
  frames_ = static_cast<unsigned>(progress.frames);
  if (!renderer_) return;
  std::vector<fs::path> late;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_ / "frames"))
    if (draft(entry.path()) || picture_number(entry.path()).value_or(0) >= frames_)
      late.push_back(entry.path());
  for (const fs::path& file : late) fs::remove(file);
  if (!video_) return;
  // A film cannot be gone on with: it is made again from the pictures.
  film_ = std::make_unique<Film>(folder_ / "film.mp4", scene_.render.size[0], scene_.render.size[1],
                                 scene_.output.fps);
  for (unsigned frame = 0; frame < frames_; ++frame) film_->add(read_png(picture(folder_, frame)));
}

void RunOutputs::append(StatisticsRow row) {
  statistics_->append(row);
  rows_.push_back(std::move(row));
}

void RunOutputs::write_data(unsigned frame) {
  FrameOutput& output = *simulation_.frame();
  Device& device = simulation_.device();
  const std::vector<Real4<double>> particles = device.download_real4(output.particle());
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
    fields.push_back(output.field(name, width));
    widths.push_back(width);
  }
  std::vector<BodyFrame> bodies;
  const Rows rows(model_, output.present());
  rows.keep(positions, 3);
  for (std::size_t f = 0; f < fields.size(); ++f) rows.keep(fields[f], widths[f]);
  for (const BodyModel& body : model_.bodies) {
    const std::size_t first = rows.before(body.first), count = rows.before(body.first + body.count) - first;
    BodyFrame block{std::span(positions).subspan(3 * first, 3 * count), {}, {}};
    for (std::size_t f = 0; f < fields.size(); ++f)
      block.fields.push_back(std::span<const float>(fields[f]).subspan(widths[f] * first, widths[f] * count));
    bodies.push_back(block);
  }
  std::vector<std::uint32_t> torn;
  if (output.vertex()) {
    if (output.torn()) torn = device.download_uint(output.torn());
    for (const Real4<double>& v : device.download_real4(output.vertex()))
      vertices.insert(vertices.end(),
                      {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
    const std::vector<std::uint32_t>& first = output.skin().first;
    const auto torn_of = [&](std::size_t b) {
      const std::vector<std::uint32_t>& triangle = output.first_triangle();
      return torn.empty()
                 ? std::span<const std::uint32_t>{}
                 : std::span<const std::uint32_t>(torn).subspan(triangle[b], triangle[b + 1] - triangle[b]);
    };
    for (std::size_t b = 0; b < model_.bodies.size(); ++b)
      if (model_.bodies[b].surface)
        bodies.push_back({std::span<const float>(vertices).subspan(3 * std::size_t{first[b]},
                                                                   3 * std::size_t{first[b + 1] - first[b]}),
                          {},
                          torn_of(b)});
  }
  writer_->append(frame, bodies);
}

void RunOutputs::write_frame(unsigned frame) {
  FrameOutput* output = simulation_.frame();
  frames_ = frame + 1;
  if (!output) return;
  output->update();
  if (writer_) write_data(frame);
  if (!renderer_) return;
  const Image image = renderer_->draw(
      simulation_.device(), {output->particle(), output->vertex(), simulation_.time(), output->torn()});
  write_png(image, picture(folder_, frame));
  if (film_) film_->add(image);
}

RunProgress RunOutputs::progress() const {
  RunProgress progress;
  progress.frames = frames_;
  statistics_->sync();
  progress.statistics_bytes = statistics_->bytes();
  progress.pictures = renderer_ != nullptr;
  if (writer_) progress.data = writer_->mark();
  return progress;
}

void RunOutputs::close() {
  if (film_) film_->close();
  if (writer_) writer_->close();
}

std::string scene_fingerprint(const Scene& scene, const Model& model) {
  Fingerprint print;
  print.add(scene_to_json(scene).dump());
  print.add(std::as_bytes(std::span(model.position)));
  print.add(std::as_bytes(std::span(model.mass)));
  print.add(std::as_bytes(std::span(model.bonds.neighbour)));
  print.add(std::as_bytes(std::span(model.bonds.weight)));
  for (const Boundary& boundary : scene.boundaries)
    if (boundary.shape.kind == Shape::Kind::mesh)
      print.add(read_text_file(find_mesh(boundary.shape.mesh, scene.file.parent_path())));
  return print.text();
}

void clear_run(const fs::path& folder) {
  constexpr std::array files = {"run.vtkhdf", "run.xmf", "statistics.csv", "run.json", "film.mp4"};
  if (!fs::is_directory(folder)) return;
  std::vector<fs::path> ours;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const std::string plain = draft(entry.path()) ? entry.path().stem().string() : name;
    bool known = std::find(files.begin(), files.end(), plain) != files.end();
    if (name == "frames" || name == "checkpoints") {
      known = true;
      for (const fs::directory_entry& inner : fs::directory_iterator(entry.path()))
        known = known && (draft(inner.path()) || (name == "frames" && picture_number(inner.path())));
    }
    if (!known) return;
    ours.push_back(entry.path());
  }
  for (const fs::path& path : ours) fs::remove_all(path);
}

} // namespace pliant
