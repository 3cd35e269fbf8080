// statistics.csv: a row a time step, there as soon as the step is done.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

struct StatisticsRow {
  std::uint64_t step = 0;
  double time = 0; ///< s, at the end of the step
  std::uint64_t iterations = 0;
  double residual = 0;                        ///< relative
  std::string stopped;                        ///< tolerance, floor or cap: what ended the iterations
  double kinetic_energy = 0;                  ///< J
  double elastic_energy = 0;                  ///< J
  std::array<double, 3> momentum = {0, 0, 0}; ///< kg m/s
  double ms_total = 0;
  std::vector<double> ms_components; ///< in the order of the header
  /// Scenes whose bonds may break: bonds broken and J released so far, the last two columns.
  std::optional<std::array<double, 2>> fracture = std::nullopt;
  /// Scenes with a line search on a potential: estimated energy error and iterates that rose, two columns.
  std::optional<std::array<double, 2>> energy = std::nullopt;
  /// Scenes with plasticity, after those: particles that flowed, J of plastic work so far, the largest
  /// plastic strain, m3 of plastic volume, solves of the step, the share lost in its last return.
  std::optional<std::array<double, 6>> plastic = std::nullopt;
  /// Scenes of fluids, the last: mean density error inside, the largest, sum of |grad rho|^2, particles
  /// removed so far.
  std::optional<std::array<double, 4>> fluid = std::nullopt;
  /// Where fluids have viscosity or redistribution, after those: iterations and relative residual of the
  /// former, mean (support |grad rho| / rho)^2 inside.
  std::optional<std::array<double, 3>> forces = std::nullopt;
  /// Where fluids have emitters or sinks, after those: particles emitted and sunk so far, and present.
  std::optional<std::array<double, 3>> flow = std::nullopt;
};

class StatisticsWriter {
public:
  /// Writes the header: step, time, iterations, residual, stopped, kinetic_energy, elastic_energy,
  /// momentum_x, momentum_y, momentum_z, ms_total, then ms_<component>; with a component "failure" then
  /// broken_bonds, fracture_energy; with `energies` then energy_error, energy_rises; with "plasticity" then
  /// yielding, plastic_work, plastic_strain, plastic_volume, plastic_rounds, yield_excess; with "density"
  /// then density_error, largest_density_error, density_slope, removed; with "viscosity" or "redistribution"
  /// then viscosity_iterations, viscosity_residual, unevenness; with "emitters" or "sinks" then emitted,
  /// sunk, present. Replaces what is there. Throws Error(input_output).
  StatisticsWriter(const std::filesystem::path& path, const std::vector<std::string>& components,
                   bool energies);
  /// Goes on with a file whose first `bytes` are kept; what lies beyond is dropped.
  /// Throws Error(input_output) where it is missing, shorter, or has other columns.
  StatisticsWriter(const std::filesystem::path& path, const std::vector<std::string>& components,
                   bool energies, std::uint64_t bytes);
  ~StatisticsWriter();
  StatisticsWriter(const StatisticsWriter&) = delete;
  StatisticsWriter& operator=(const StatisticsWriter&) = delete;

  /// Writes a row, with the shortest digits that read back as the same doubles. A row that does not fit on
  /// the disk is taken back whole. Throws Error(input_output).
  void append(const StatisticsRow& row);
  std::uint64_t bytes() const { return static_cast<std::uint64_t>(size_); } ///< so far
  /// Waits until all rows so far are on the disk.
  void sync() const;

private:
  void open(int flags);
  void write(const std::string& line);
  std::filesystem::path path_;
  std::size_t components_;
  int file_ = -1;
  std::int64_t size_ = 0;
};

/// The rows of such a file; its last, half line is left out. Throws Error(input_output).
std::vector<StatisticsRow> read_statistics(const std::filesystem::path& path);

} // namespace pliant
