// One block of a VTKHDF file.
#include "engine/io/vtkhdf.h"

#include <algorithm>
#include <numeric>

namespace pliant {

namespace {

constexpr std::uint64_t step_chunk = 64;         ///< rows; small tables of one row a frame
constexpr std::uint64_t most_chunk_rows = 65536; ///< 768 KiB of positions: below HDF5's chunk cache of 1 MiB

// A frame is a whole number of chunks where its size does not vary, so that no chunk is written twice.
std::uint64_t rows_of_chunk(std::uint64_t points) {
  if (points < 256) return 256;
  const std::uint64_t pieces = (points + most_chunk_rows - 1) / most_chunk_rows;
  return (points + pieces - 1) / pieces;
}

} // namespace

void write_vtkhdf_head(h5::Group& group, const std::string& type, std::int64_t minor_version) {
  const std::array<std::int64_t, 2> version = {2, minor_version};
  group.set_attribute<std::int64_t>("Version", version, false);
  group.set_text_attribute("Type", type);
}

VtkHdfBlock::Cells VtkHdfBlock::create_cells(const std::string& name) {
  using h5::Type;
  h5::Group made = group_.create_group(name, true);
  return {made.create_dataset("NumberOfCells", Type::int64, 1, step_chunk),
          made.create_dataset("NumberOfConnectivityIds", Type::int64, 1, step_chunk),
          made.create_dataset("Connectivity", Type::int64, 1,
                              name == "Vertices" || name == "Polygons" ? 4096 : 1),
          made.create_dataset("Offsets", Type::int64, 1, 2 * step_chunk)};
}

VtkHdfBlock::VtkHdfBlock(h5::Group group, const BodyOutput& body, std::int64_t minor_version)
    : group_(std::move(group)), specs_(body.fields), cloud_(body.kind == BodyOutput::Kind::particles),
      chunk_rows_(rows_of_chunk(body.points)),
      points_(group_.create_dataset("Points", h5::Type::float32, 3, chunk_rows_)),
      point_counts_(group_.create_dataset("NumberOfPoints", h5::Type::int64, 1, step_chunk)),
      steps_(group_.create_group("Steps", true)),
      values_(steps_.create_dataset("Values", h5::Type::float64, 1, step_chunk)),
      part_offsets_(steps_.create_dataset("PartOffsets", h5::Type::int64, 1, step_chunk)),
      part_counts_(steps_.create_dataset("NumberOfParts", h5::Type::int64, 1, step_chunk)),
      point_offsets_(steps_.create_dataset("PointOffsets", h5::Type::int64, 1, step_chunk)),
      cell_offsets_(steps_.create_dataset("CellOffsets", h5::Type::int64, 4, step_chunk)),
      id_offsets_(steps_.create_dataset("ConnectivityIdOffsets", h5::Type::int64, 4, step_chunk)) {
  write_vtkhdf_head(group_, "PolyData", minor_version);
  steps_.set_attribute<std::int64_t>("NSteps", 0);
  h5::Group point_data = group_.create_group("PointData", true);
  h5::Group offsets = steps_.create_group("PointDataOffsets", true);
  for (const FieldSpec& field : specs_) {
    fields_.push_back(
        point_data.create_dataset(field.name, h5::Type::float32, field.components, chunk_rows_));
    field_offsets_.push_back(offsets.create_dataset(field.name, h5::Type::int64, 1, step_chunk));
  }
  for (const char* name : {"Vertices", "Lines", "Polygons", "Strips"}) cells_.push_back(create_cells(name));
  if (cloud_) return;

  // Triangles: one part, its topology written once, and again whenever some have torn.
  count_ = body.points;
  triangles_ = body.triangles;
  torn_.assign(triangles_.size(), 0);
  append_triangles();
  if (!body.tears) triangles_ = {}, torn_ = {};
}

// A part with the triangles that are left.
void VtkHdfBlock::append_triangles() {
  if (topology_ >= 0) cells_before_ = static_cast<std::int64_t>(cells_[2].connectivity.rows() / 3);
  ++topology_;
  std::vector<std::int64_t> corners;
  corners.reserve(3 * triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    if (torn_[t] == 0) corners.insert(corners.end(), triangles_[t].begin(), triangles_[t].end());
  point_counts_.append(static_cast<std::int64_t>(count_));
  for (std::size_t kind = 0; kind < cells_.size(); ++kind) {
    const auto count = static_cast<std::int64_t>(kind == 2 ? corners.size() / 3 : 0);
    cells_[kind].counts.append(count);
    cells_[kind].id_counts.append(3 * count);
    std::vector<std::int64_t> starts(static_cast<std::size_t>(count) + 1);
    for (std::size_t i = 0; i < starts.size(); ++i) starts[i] = static_cast<std::int64_t>(3 * i);
    cells_[kind].offsets.append(std::span<const std::int64_t>(starts));
  }
  if (!corners.empty()) cells_[2].connectivity.append(std::span<const std::int64_t>(corners));
}

VtkHdfBlock::Cells VtkHdfBlock::open_cells(const std::string& name) const {
  const h5::Group found = group_.group(name);
  return {found.dataset("NumberOfCells"), found.dataset("NumberOfConnectivityIds"),
          found.dataset("Connectivity"), found.dataset("Offsets")};
}

VtkHdfBlock::VtkHdfBlock(h5::Group group, const BodyOutput& body)
    : group_(std::move(group)), specs_(body.fields), cloud_(body.kind == BodyOutput::Kind::particles),
      chunk_rows_(rows_of_chunk(body.points)), points_(group_.dataset("Points")),
      point_counts_(group_.dataset("NumberOfPoints")), steps_(group_.group("Steps")),
      values_(steps_.dataset("Values")), part_offsets_(steps_.dataset("PartOffsets")),
      part_counts_(steps_.dataset("NumberOfParts")), point_offsets_(steps_.dataset("PointOffsets")),
      cell_offsets_(steps_.dataset("CellOffsets")), id_offsets_(steps_.dataset("ConnectivityIdOffsets")),
      steps_written_(values_.rows()) {
  for (const FieldSpec& field : specs_) {
    fields_.push_back(group_.dataset("PointData/" + field.name));
    field_offsets_.push_back(steps_.dataset("PointDataOffsets/" + field.name));
  }
  for (const char* name : {"Vertices", "Lines", "Polygons", "Strips"}) cells_.push_back(open_cells(name));
  if (cloud_) {
    for (const std::int64_t cells : cells_[0].counts.read<std::int64_t>()) cells_before_ += cells;
    return;
  }
  const std::vector<std::int64_t> counts = cells_[2].counts.read<std::int64_t>();
  topology_ = static_cast<std::int64_t>(counts.size()) - 1;
  for (std::size_t k = 0; k + 1 < counts.size(); ++k) cells_before_ += counts[k];
  if (!body.tears) return;
  triangles_ = body.triangles;
  torn_.assign(triangles_.size(), 1); // what the last topology has, in its order, is not
  const std::vector<std::int64_t> corners = cells_[2].connectivity.read<std::int64_t>();
  auto at = static_cast<std::size_t>(3 * cells_before_);
  for (std::size_t t = 0; t < triangles_.size() && at < corners.size(); ++t)
    if (std::equal(triangles_[t].begin(), triangles_[t].end(),
                   corners.begin() + static_cast<std::ptrdiff_t>(at)))
      torn_[t] = 0, at += 3;
}

std::vector<std::array<std::uint64_t, 2>> VtkHdfBlock::chunks(bool all) const {
  std::vector<std::array<std::uint64_t, 2>> found;
  const auto add = [&](const h5::Dataset& data) {
    for (const auto& chunk : data.chunks(all ? 0 : first_, all ? data.rows() : count_))
      found.push_back(chunk);
  };
  add(points_);
  for (const h5::Dataset& field : fields_) add(field);
  return found;
}

void VtkHdfBlock::append_data(const BodyFrame& frame) {
  first_ = points_.rows();
  count_ = frame.positions.size() / 3;
  points_.append(frame.positions);
  for (std::size_t i = 0; i < fields_.size(); ++i) fields_[i].append(frame.fields[i]);
  if (cloud_) append_topology();
  if (!triangles_.empty() && !std::equal(torn_.begin(), torn_.end(), frame.torn.begin(), frame.torn.end())) {
    torn_.assign(frame.torn.begin(), frame.torn.end());
    append_triangles();
  }
}

// A cloud's step is a part of its own: one poly-vertex cell, or none where the step is empty. Its ids always
// start from 0, so that one list as long as the largest step serves all.
void VtkHdfBlock::append_topology() {
  const auto count = static_cast<std::int64_t>(count_);
  point_counts_.append(count);
  for (std::size_t kind = 0; kind < cells_.size(); ++kind) {
    const std::int64_t ids = kind == 0 ? count : 0;
    cells_[kind].counts.append(std::int64_t(ids > 0 ? 1 : 0));
    cells_[kind].id_counts.append(ids);
    cells_[kind].offsets.append(std::int64_t(0));
    if (ids > 0) cells_[kind].offsets.append(ids);
  }
  h5::Dataset& ids = cells_[0].connectivity;
  if (count_ > ids.rows()) {
    std::vector<std::int64_t> more(count_ - ids.rows());
    std::iota(more.begin(), more.end(), static_cast<std::int64_t>(ids.rows()));
    ids.append(std::span<const std::int64_t>(more));
  }
}

void VtkHdfBlock::append_step(double time) {
  const auto start = static_cast<std::int64_t>(first_);
  part_offsets_.append(cloud_ ? static_cast<std::int64_t>(steps_written_) : topology_);
  part_counts_.append(std::int64_t(1));
  point_offsets_.append(start);
  const std::int64_t polygons = cloud_ ? 0 : cells_before_;
  const std::array<std::int64_t, 4> cells = {cells_before_ - polygons, 0, polygons, 0},
                                    ids = {0, 0, 3 * polygons, 0};
  cell_offsets_.append(std::span<const std::int64_t>(cells));
  id_offsets_.append(std::span<const std::int64_t>(ids));
  for (h5::Dataset& offsets : field_offsets_) offsets.append(start);
  values_.append(time);
  if (cloud_ && count_ > 0) ++cells_before_;
  steps_.set_attribute<std::int64_t>("NSteps", static_cast<std::int64_t>(++steps_written_));
}

void VtkHdfBlock::append_views(h5::Group& root, const std::string& folder) const {
  if (count_ == 0) return;
  root.create_view(folder + "/position", h5::Type::float32, points_, first_, count_);
  for (std::size_t i = 0; i < fields_.size(); ++i)
    root.create_view(folder + "/" + specs_[i].name, h5::Type::float32, fields_[i], first_, count_);
  if (triangles_.empty()) return;
  const h5::Dataset& corners = cells_[2].connectivity;
  const auto start = static_cast<std::uint64_t>(3 * cells_before_);
  if (corners.rows() > start)
    root.create_view(folder + "/corners", h5::Type::int64, corners, start, corners.rows() - start);
}

std::uint64_t VtkHdfBlock::growth(std::uint64_t points) const {
  std::uint64_t values = 3;
  for (const FieldSpec& field : specs_) values += field.components;
  // Whole chunks; ids of two kinds; and, with room to spare, a few kilobytes a dataset of bookkeeping.
  return (points + chunk_rows_) * values * sizeof(float) + (points + 4096) * 12 +
         (fields_.size() + 30) * 4096 + triangles_.size() * 32;
}

} // namespace pliant
