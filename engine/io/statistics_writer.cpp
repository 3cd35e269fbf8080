// statistics.csv: a row a time step.
#include "engine/io/statistics_writer.h"

#include "engine/core/error.h"
#include "engine/io/folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sstream>
#include <unistd.h>

namespace pliant {

namespace {

constexpr std::size_t plain_columns = 11;
constexpr const char* fracture_columns = ",broken_bonds,fracture_energy";
constexpr const char* energy_columns = ",energy_error,energy_rises";
constexpr const char* plastic_columns = ",yielding,plastic_work,plastic_strain,plastic_volume,"
                                        "plastic_rounds,yield_excess";
constexpr const char* fluid_columns = ",density_error,largest_density_error,density_slope,removed";

constexpr const char* force_columns = ",viscosity_iterations,viscosity_residual,unevenness";
constexpr const char* flow_columns = ",emitted,sunk,present";

std::string header_of(const std::filesystem::path& path, const std::vector<std::string>& components,
                      bool energies) {
  std::string header =
      "step,time,iterations,residual,stopped,kinetic_energy,elastic_energy,momentum_x,momentum_y,"
      "momentum_z,ms_total";
  for (const std::string& component : components) {
    if (component.empty() || component.find_first_of(",\"\r\n") != std::string::npos)
      throw Error(ExitCode::internal,
                  fmt::format("\"{}\" cannot name a column of {}", component, path.string()));
    header += ",ms_" + component;
  }
  if (std::find(components.begin(), components.end(), "failure") != components.end())
    header += fracture_columns;
  if (energies) header += energy_columns;
  if (std::find(components.begin(), components.end(), "plasticity") != components.end())
    header += plastic_columns;
  if (std::find(components.begin(), components.end(), "density") != components.end()) header += fluid_columns;
  for (const char* component : {"viscosity", "redistribution"})
    if (std::find(components.begin(), components.end(), component) != components.end()) {
      header += force_columns;
      break;
    }
  for (const char* component : {"emitters", "sinks"})
    if (std::find(components.begin(), components.end(), component) != components.end()) {
      header += flow_columns;
      break;
    }
  return header + "\n";
}

} // namespace

void StatisticsWriter::open(int flags) {
  file_ = ::open(path_.c_str(), flags | O_CLOEXEC, 0666);
  if (file_ < 0)
    throw Error(ExitCode::input_output,
                fmt::format("cannot write {}: {}", path_.string(), std::strerror(errno)));
}

StatisticsWriter::StatisticsWriter(const std::filesystem::path& path,
                                   const std::vector<std::string>& components, bool energies)
    : path_(path), components_(components.size()) {
  const std::string header = header_of(path, components, energies);
  open(O_WRONLY | O_CREAT | O_TRUNC);
  try {
    write(header);
  } catch (...) {
    ::close(file_);
    throw;
  }
}

StatisticsWriter::StatisticsWriter(const std::filesystem::path& path,
                                   const std::vector<std::string>& components, bool energies,
                                   std::uint64_t bytes)
    : path_(path), components_(components.size()) {
  const std::string header = header_of(path, components, energies);
  const std::string text = read_text_file(path);
  if (text.size() < bytes || bytes < header.size() || text.compare(0, header.size(), header) != 0 ||
      text[bytes - 1] != '\n')
    throw Error(ExitCode::input_output,
                fmt::format("{} is not the one that the checkpoint goes on with: it is shorter, or has other "
                            "columns; start the run anew in another folder",
                            path.string()));
  open(O_WRONLY);
  size_ = static_cast<std::int64_t>(bytes);
  if (::ftruncate(file_, size_) == 0 && ::lseek(file_, size_, SEEK_SET) >= 0) return;
  const std::string why = std::strerror(errno);
  ::close(file_);
  throw Error(ExitCode::input_output, fmt::format("cannot write {}: {}", path.string(), why));
}

void StatisticsWriter::sync() const {
  if (::fsync(file_) != 0)
    throw Error(ExitCode::input_output,
                fmt::format("cannot write {}: {}", path_.string(), std::strerror(errno)));
}

StatisticsWriter::~StatisticsWriter() {
  if (file_ >= 0) ::close(file_);
}

void StatisticsWriter::write(const std::string& line) {
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t count = ::write(file_, line.data() + done, line.size() - done);
    if (count > 0) {
      done += static_cast<std::size_t>(count);
    } else if (count < 0 && errno != EINTR) {
      const std::string why = std::strerror(errno);
      const bool whole = ::ftruncate(file_, size_) == 0 && ::lseek(file_, size_, SEEK_SET) >= 0;
      throw Error(ExitCode::input_output, fmt::format("cannot write {}: {}{}", path_.string(), why,
                                                      whole ? "; the rows before are intact" : ""));
    }
  }
  size_ += static_cast<std::int64_t>(line.size());
}

void StatisticsWriter::append(const StatisticsRow& row) {
  if (row.ms_components.size() != components_)
    throw Error(ExitCode::internal, fmt::format("a row of {} has {} components, its header {}",
                                                path_.string(), row.ms_components.size(), components_));
  std::string line = fmt::format("{},{},{},{},{},{},{},{},{},{},{}", row.step, row.time, row.iterations,
                                 row.residual, row.stopped, row.kinetic_energy, row.elastic_energy,
                                 row.momentum[0], row.momentum[1], row.momentum[2], row.ms_total);
  for (const double ms : row.ms_components) line += fmt::format(",{}", ms);
  if (row.fracture) line += fmt::format(",{:.0f},{}", (*row.fracture)[0], (*row.fracture)[1]);
  if (row.energy) line += fmt::format(",{},{:.0f}", (*row.energy)[0], (*row.energy)[1]);
  if (row.plastic)
    line += fmt::format(",{:.0f},{},{},{},{:.0f},{}", (*row.plastic)[0], (*row.plastic)[1], (*row.plastic)[2],
                        (*row.plastic)[3], (*row.plastic)[4], (*row.plastic)[5]);
  if (row.fluid)
    line +=
        fmt::format(",{},{},{},{:.0f}", (*row.fluid)[0], (*row.fluid)[1], (*row.fluid)[2], (*row.fluid)[3]);
  if (row.forces) line += fmt::format(",{:.0f},{},{}", (*row.forces)[0], (*row.forces)[1], (*row.forces)[2]);
  if (row.flow) line += fmt::format(",{:.0f},{:.0f},{:.0f}", (*row.flow)[0], (*row.flow)[1], (*row.flow)[2]);
  write(line + "\n");
}

std::vector<StatisticsRow> read_statistics(const std::filesystem::path& path) {
  std::istringstream text(read_text_file(path));
  std::vector<StatisticsRow> rows;
  std::string line;
  std::getline(text, line);
  const auto ends_in = [&line](const std::string& columns) { // and is cut off
    if (line.size() < columns.size() ||
        line.compare(line.size() - columns.size(), columns.size(), columns) != 0)
      return false;
    line.resize(line.size() - columns.size());
    return true;
  };
  const bool flow = ends_in(flow_columns), forces = ends_in(force_columns), fluid = ends_in(fluid_columns),
             plastic = ends_in(plastic_columns), energies = ends_in(energy_columns),
             fracture = ends_in(fracture_columns);
  while (std::getline(text, line) && !text.eof()) {
    std::vector<std::string> cells(1);
    for (const char c : line)
      if (c == ',')
        cells.emplace_back();
      else
        cells.back() += c;
    const auto damaged = [&] {
      return Error(ExitCode::input_output,
                   fmt::format("{}, line {} is no row of statistics", path.string(), rows.size() + 2));
    };
    if (cells.size() < plain_columns) throw damaged();
    const auto number = [&](std::size_t cell) {
      char* end = nullptr;
      const double value = std::strtod(cells[cell].c_str(), &end);
      if (cells[cell].empty() || *end != '\0') throw damaged();
      return value;
    };
    StatisticsRow row{static_cast<std::uint64_t>(number(0)),
                      number(1),
                      static_cast<std::uint64_t>(number(2)),
                      number(3),
                      cells[4],
                      number(5),
                      number(6),
                      {number(7), number(8), number(9)},
                      number(10),
                      {}};
    if (flow) {
      if (cells.size() < plain_columns + 3) throw damaged();
      row.flow.emplace();
      for (std::size_t c = 0; c < 3; ++c) (*row.flow)[c] = number(cells.size() - 3 + c);
      cells.resize(cells.size() - 3);
    }
    if (forces) {
      if (cells.size() < plain_columns + 3) throw damaged();
      row.forces.emplace();
      for (std::size_t c = 0; c < 3; ++c) (*row.forces)[c] = number(cells.size() - 3 + c);
      cells.resize(cells.size() - 3);
    }
    if (fluid) {
      if (cells.size() < plain_columns + 4) throw damaged();
      row.fluid.emplace();
      for (std::size_t c = 0; c < 4; ++c) (*row.fluid)[c] = number(cells.size() - 4 + c);
      cells.resize(cells.size() - 4);
    }
    if (plastic) {
      const std::size_t columns = row.plastic.emplace().size();
      if (cells.size() < plain_columns + columns) throw damaged();
      for (std::size_t c = 0; c < columns; ++c) (*row.plastic)[c] = number(cells.size() - columns + c);
      cells.resize(cells.size() - columns);
    }
    if (energies) {
      if (cells.size() < plain_columns + 2) throw damaged();
      row.energy = {number(cells.size() - 2), number(cells.size() - 1)};
      cells.resize(cells.size() - 2);
    }
    if (fracture) {
      if (cells.size() < plain_columns + 2) throw damaged();
      row.fracture = {number(cells.size() - 2), number(cells.size() - 1)};
      cells.resize(cells.size() - 2);
    }
    for (std::size_t c = plain_columns; c < cells.size(); ++c) row.ms_components.push_back(number(c));
    rows.push_back(std::move(row));
  }
  return rows;
}

} // namespace pliant
