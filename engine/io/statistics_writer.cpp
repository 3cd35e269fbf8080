// statistics.csv: a row a time step.
#include "engine/io/statistics_writer.h"

#include "engine/core/error.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace pliant {

StatisticsWriter::StatisticsWriter(const std::filesystem::path& path,
                                   const std::vector<std::string>& components)
    : path_(path), components_(components.size()) {
  std::string header =
      "step,time,iterations,residual,kinetic_energy,elastic_energy,momentum_x,momentum_y,momentum_z,"
      "ms_total";
  for (const std::string& component : components) {
    if (component.empty() || component.find_first_of(",\"\r\n") != std::string::npos)
      throw Error(ExitCode::internal,
                  fmt::format("\"{}\" cannot name a column of {}", component, path.string()));
    header += ",ms_" + component;
  }
  file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0)
    throw Error(ExitCode::input_output,
                fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
  try {
    write(header + "\n");
  } catch (...) {
    ::close(file_);
    throw;
  }
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
  std::string line = fmt::format("{},{},{},{},{},{},{},{},{},{}", row.step, row.time, row.iterations,
                                 row.residual, row.kinetic_energy, row.elastic_energy, row.momentum[0],
                                 row.momentum[1], row.momentum[2], row.ms_total);
  for (const double ms : row.ms_components) line += fmt::format(",{}", ms);
  write(line + "\n");
}

} // namespace pliant
