// The visual record of a run.
#include "engine/io/run_writer.h"

#include "engine/core/error.h"
#include "engine/io/hdf5.h"
#include "engine/io/vtkhdf.h"
#include "engine/io/xdmf.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <optional>
#include <set>

namespace pliant {

namespace {

constexpr const char* data_file = "run.vtkhdf";

bool good_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  if (name.empty() || !letter(name.front())) return false;
  for (const char c : name)
    if (!letter(c) && !(c >= '0' && c <= '9') && c != '-') return false;
  return true;
}

void check_names(const std::vector<BodyOutput>& bodies) {
  const char* rule = "a name starts with a letter or _ and goes on with letters, digits, - and _";
  std::set<std::string> seen = {"Assembly"};
  for (const BodyOutput& body : bodies) {
    if (!good_name(body.name))
      throw Error(ExitCode::usage,
                  fmt::format("body \"{}\" cannot be written to {}: {}", body.name, data_file, rule));
    if (!seen.insert(body.name).second)
      throw Error(ExitCode::usage,
                  fmt::format("body \"{}\" cannot be written to {}: the name is {}; choose another",
                              body.name, data_file,
                              body.name == "Assembly" ? "reserved" : "taken by another body"));
    std::set<std::string> fields = {"position", "id"};
    for (const FieldSpec& field : body.fields) {
      if (!good_name(field.name) || !fields.insert(field.name).second)
        throw Error(ExitCode::usage,
                    fmt::format("field \"{}\" of body \"{}\" cannot be written to {}: {}, is not used "
                                "twice, and is neither \"position\" nor \"id\"",
                                field.name, body.name, data_file, rule));
      if (field.components != 1 && field.components != 3)
        throw Error(ExitCode::internal,
                    fmt::format("field \"{}\" of body \"{}\" has {} components, not 1 or 3", field.name,
                                body.name, field.components));
    }
    for (const auto& triangle : body.triangles)
      for (const std::uint32_t corner : triangle)
        if (corner >= body.points)
          throw Error(ExitCode::internal,
                      fmt::format("a triangle of body \"{}\" has corner {} of {} vertices", body.name, corner,
                                  body.points));
  }
}

void check_finite(std::span<const float> values, unsigned components, const BodyOutput& body,
                  const std::string& field, std::uint64_t frame) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw Error(
          ExitCode::diverged,
          fmt::format("the simulation diverged: {} of {} {} of body \"{}\" is {} in frame {}; earlier frames "
                      "are kept, this one is not written. Try a smaller time step or more iterations",
                      field, body.kind == BodyOutput::Kind::particles ? "particle" : "vertex", i / components,
                      body.name, values[i], frame));
}

void check_frame(const std::vector<BodyOutput>& bodies, const std::vector<BodyFrame>& frames,
                 std::uint64_t frame) {
  if (frames.size() != bodies.size())
    throw Error(ExitCode::internal,
                fmt::format("frame {} has {} bodies, the file {}", frame, frames.size(), bodies.size()));
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::size_t points = frames[b].positions.size() / 3;
    bool fits = frames[b].positions.size() == 3 * points &&
                frames[b].fields.size() == bodies[b].fields.size() &&
                (bodies[b].kind == BodyOutput::Kind::particles || points == bodies[b].points) &&
                frames[b].torn.size() == (bodies[b].tears ? bodies[b].triangles.size() : 0);
    for (std::size_t f = 0; fits && f < bodies[b].fields.size(); ++f)
      fits = frames[b].fields[f].size() == points * bodies[b].fields[f].components;
    if (!fits)
      throw Error(
          ExitCode::internal,
          fmt::format("the arrays of body \"{}\" in frame {} do not have the sizes that were announced",
                      bodies[b].name, frame));
    check_finite(frames[b].positions, 3, bodies[b], "position", frame);
    for (std::size_t f = 0; f < bodies[b].fields.size(); ++f)
      check_finite(frames[b].fields[f], bodies[b].fields[f].components, bodies[b], bodies[b].fields[f].name,
                   frame);
  }
}

} // namespace

struct RunWriter::Impl {
  std::filesystem::path path;
  std::vector<BodyOutput> bodies;
  double fps;
  h5::File file;
  h5::Group root;
  h5::Dataset ids;
  std::vector<VtkHdfBlock> blocks;
  XdmfWriter xdmf;
  std::uint64_t frames = 0;
  std::uint64_t next_frame = 0;
  std::vector<std::array<std::uint64_t, 2>> bulk; ///< chunks of the frames so far: what a mark leaves out
  bool broken = false;                            ///< a frame was left half written: nothing more is added

  Impl(const std::filesystem::path& folder, std::vector<BodyOutput> outputs, double frames_per_second)
      : path(folder / data_file), bodies(std::move(outputs)), fps(frames_per_second),
        file(h5::File::create(path)), root(file.root()),
        ids(root.create_dataset("ids", h5::Type::int32, 1, 4096)), xdmf(folder / "run.xmf", data_file) {
    std::uint64_t room = 1 << 16;
    for (const BodyOutput& body : bodies) room += 1 << 17, room += 8 * (4 * body.triangles.size() + 1);
    file.reserve(room);
    h5::Group sim = root.create_group("sim");
    sim.set_text_attribute("engine", "pliant " PLIANT_VERSION);
    sim.set_attribute("fps", fps);
    h5::Group top = root.create_group("VTKHDF", true);
    if (bodies.size() == 1) {
      blocks.emplace_back(std::move(top), bodies.front(), 0);
    } else {
      write_vtkhdf_head(top, "PartitionedDataSetCollection", 1);
      h5::Group assembly = top.create_group("Assembly", true);
      std::int64_t index = 0;
      for (const BodyOutput& body : bodies) {
        blocks.emplace_back(top.create_group(body.name, true), body, 1);
        blocks.back().group().set_attribute("Index", index++);
        assembly.create_group(body.name, true).soft_link(body.name, "/VTKHDF/" + body.name);
      }
    }
    file.flush();
    xdmf.write(true);
  }

  // Goes on after a mark that has been restored.
  Impl(const std::filesystem::path& folder, std::vector<BodyOutput> outputs, double frames_per_second,
       const RunMark& mark)
      : path(folder / data_file), bodies(std::move(outputs)), fps(frames_per_second),
        file(h5::File::open(path, true)), root(file.root()), ids(root.dataset("ids")),
        xdmf(folder / "run.xmf", data_file), frames(mark.frames), next_frame(mark.next_frame) {
    const h5::Group top = root.group("VTKHDF");
    for (const BodyOutput& body : bodies) {
      blocks.emplace_back(bodies.size() == 1 ? root.group("VTKHDF") : top.group(body.name), body);
      for (const auto& chunk : blocks.back().chunks(true)) bulk.push_back(chunk);
    }
    if (frames > 0)
      for (const std::string& name : root.group("frames").names()) {
        std::vector<std::uint64_t> points;
        for (const BodyOutput& body : bodies) {
          const std::string view = "/frames/" + name + "/" + body.name + "/position";
          points.push_back(root.has(view) ? root.dataset(view).rows() : 0);
        }
        append_xdmf("/frames/" + name, std::stod(name) / fps, points);
      }
    xdmf.write(true);
  }

  void append_ids(std::uint64_t count) {
    if (count <= ids.rows()) return;
    std::vector<std::int32_t> more(count - ids.rows());
    std::iota(more.begin(), more.end(), static_cast<std::int32_t>(ids.rows()));
    ids.append(std::span<const std::int32_t>(more));
  }

  void append_hdf5(const std::string& folder, double time, const std::vector<BodyFrame>& values) {
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      blocks[b].append_data(values[b]);
      if (bodies[b].kind == BodyOutput::Kind::particles) append_ids(blocks[b].count());
    }
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const std::string place = folder + "/" + bodies[b].name;
      blocks[b].append_views(root, place);
      if (bodies[b].kind == BodyOutput::Kind::particles && blocks[b].count() > 0)
        root.create_view(place + "/id", h5::Type::int32, ids, 0, blocks[b].count());
    }
    if (!root.has(folder)) root.create_group(folder); // of a frame in which nothing is there yet
    for (VtkHdfBlock& block : blocks) block.append_step(time);
    file.flush();
    for (const VtkHdfBlock& block : blocks)
      for (const auto& chunk : block.chunks(false)) bulk.push_back(chunk);
  }

  void append_xdmf(const std::string& folder, double time, const std::vector<std::uint64_t>& points) {
    xdmf.begin_frame(time);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const std::string place = folder + "/" + bodies[b].name;
      std::string corners = blocks[b].group().place().object + "/Polygons/Connectivity";
      std::uint64_t triangles = bodies[b].triangles.size();
      if (bodies[b].tears) {
        corners = place + "/corners";
        triangles = root.has(corners) ? root.dataset(corners).rows() / 3 : 0;
        if (triangles == 0) continue;
      }
      if (points[b] > 0) xdmf.add_body(bodies[b], place, points[b], corners, triangles);
    }
    xdmf.end_frame();
  }
};

namespace {

void check_outputs(const std::vector<BodyOutput>& bodies, double fps) {
  if (bodies.empty()) throw Error(ExitCode::internal, "a run's file needs at least one body");
  if (!(fps > 0) || !std::isfinite(fps))
    throw Error(ExitCode::usage, fmt::format("fps must be above 0, not {}", fps));
  check_names(bodies);
}

} // namespace

RunWriter::RunWriter(const std::filesystem::path& folder, std::vector<BodyOutput> bodies, double fps) {
  check_outputs(bodies, fps);
  impl_ = std::make_unique<Impl>(folder, std::move(bodies), fps);
}

RunWriter::RunWriter(const std::filesystem::path& folder, std::vector<BodyOutput> bodies, double fps,
                     const RunMark& mark) {
  check_outputs(bodies, fps);
  restore_mark(folder / data_file, mark);
  impl_ = std::make_unique<Impl>(folder, std::move(bodies), fps, mark);
}

RunWriter::~RunWriter() = default;
RunWriter::RunWriter(RunWriter&&) noexcept = default;

void RunWriter::append(std::uint64_t frame, const std::vector<BodyFrame>& bodies) {
  Impl& run = *impl_;
  if (run.broken)
    throw Error(
        ExitCode::input_output,
        fmt::format("an earlier frame could not be written to {}; it is not continued", run.file.name()));
  if (frame < run.next_frame)
    throw Error(ExitCode::internal, fmt::format("frame {} comes after frame {}", frame, run.next_frame - 1));
  check_frame(run.bodies, bodies, frame);
  std::uint64_t room = 1 << 16;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    room += run.blocks[b].growth(bodies[b].positions.size() / 3);
  run.file.reserve(room);

  // Divided, not multiplied by 1 / fps: readers take the last step at or before a time.
  const double time = static_cast<double>(frame) / run.fps;
  const std::string folder = fmt::format("/frames/{:06}", frame);
  run.broken = true;
  run.append_hdf5(folder, time, bodies);
  std::vector<std::uint64_t> points;
  for (const VtkHdfBlock& block : run.blocks) points.push_back(block.count());
  run.append_xdmf(folder, time, points);
  run.xdmf.write(false);
  run.broken = false;
  ++run.frames;
  run.next_frame = frame + 1;
}

std::uint64_t RunWriter::frames() const {
  return impl_->frames;
}

RunMark RunWriter::mark() const {
  RunMark mark = take_mark(impl_->path, impl_->bulk);
  mark.frames = impl_->frames;
  mark.next_frame = impl_->next_frame;
  return mark;
}

void RunWriter::close() {
  if (!impl_) return;
  const std::unique_ptr<Impl> last = std::move(impl_);
  last->xdmf.write(true);
  last->blocks.clear();
  last->ids = h5::Dataset({}, {});
  last->root = h5::Group({}, {});
  last->file.close();
}

} // namespace pliant
