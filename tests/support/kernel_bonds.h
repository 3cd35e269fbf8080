// A law's range of particles with real bonds (a random subset of a lattice), as kernels get it: not at the
// start of the buffers, with NaN in all that the range may not read. Packed here, independently of
// slice_bonds().
#pragma once

#include "engine/model/model.h"
#include "tests/support/kernel_bench.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <random>

namespace pliant::test {

inline constexpr unsigned kernel_seed = 20170401; ///< printed by the tests that use it
inline constexpr std::size_t awkward_sizes[] = {1, 15, 17, 127, 129, 1000};

class Random {
public:
  explicit Random(unsigned seed) : engine_(seed) {}
  /// Exact in float, within +-size.
  double operator()(double size = 1) {
    return rounded(std::uniform_real_distribution<double>(-size, size)(engine_));
  }
  Vector3 vector(double size = 1) {
    Vector3 v;
    for (double& component : v) component = (*this)(size);
    return v;
  }
  Eigen::Quaterniond rotation() {
    Eigen::Quaterniond q((*this)(), (*this)(), (*this)(), (*this)());
    return q.normalized();
  }
  std::mt19937& engine() { return engine_; }

private:
  std::mt19937 engine_;
};

inline Vector3 rounded(const Vector3& v) {
  return v.unaryExpr([](double value) { return rounded(value); });
}

struct BondProblem {
  struct Bond {
    std::size_t to = 0;
    Vector3 reference = Vector3::Zero();
    double out = 0, in = 0; ///< c_ij, c_ji, N/m
  };
  std::uint32_t first = 37, first_slice = 3, count = 0;
  std::size_t total = 0; ///< elements of a buffer with one a particle
  double unit = 0, spacing = 0.02;
  std::vector<std::vector<Bond>> bonds; ///< of each particle of the range, `to` counts from its start
  std::vector<double> inverse_modulus, coupling;
  std::vector<Vector3> reference, position, displacement;
  Values bond_values; ///< first, first_slice, unit, slice_begin, bond, weight

  BondProblem(const std::string& law, std::size_t particles, unsigned seed, bool coincident = false) {
    Random random(seed);
    const int side = static_cast<int>(std::ceil(std::cbrt(1.4 * static_cast<double>(particles))));
    std::vector<Vector3> points;
    for (int z = 0; z < side; ++z)
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) points.push_back(spacing * Vector3(x, y, z));
    std::shuffle(points.begin(), points.end(), random.engine());
    points.resize(particles);
    Material material;
    material.law = law;
    material.poisson = law == "projective" ? 0.25 : 0.3;
    const Model model = assemble_points(points, spacing, 1.87, material, std::pow(spacing, 3), "normalised");
    count = static_cast<std::uint32_t>(model.count());
    total = first + count + 23;
    unit = rounded(spacing / reference_grid);
    take_bonds(model);
    move(random, coincident);
    pack();
  }

  /// A buffer of `width` reals a particle, `outside` beyond the range.
  std::vector<double> buffer(std::size_t width, double outside) const {
    return std::vector<double>(width * total, outside);
  }
  template <class Row> std::vector<double> rows(double outside, std::size_t width, Row row) const {
    std::vector<double> values = buffer(width, outside);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < width; ++k) values[width * (first + i) + k] = row(i, k);
    return values;
  }
  /// Groups of four: a vector and zero.
  std::vector<double> vectors(const std::vector<Vector3>& v) const {
    return rows(not_a_number, 4,
                [&](std::size_t i, std::size_t k) { return k < 3 ? v[i][static_cast<int>(k)] : 0; });
  }
  /// `shape` with its two rows of constants; more rows are NaN.
  std::vector<double> shape(std::size_t row_count) const {
    std::vector<double> values(row_count * total, not_a_number);
    for (std::size_t i = 0; i < count; ++i) {
      values[first + i] = inverse_modulus[i];
      values[total + first + i] = coupling[i];
    }
    return values;
  }
  Vector3 current(std::size_t i, const Bond& bond) const {
    return (position[bond.to] - position[i]) + (displacement[bond.to] - displacement[i]);
  }
  /// Elements that a particle's own value reaches: itself and its neighbours.
  std::vector<std::size_t> reach(std::size_t i) const {
    std::vector<std::size_t> found{first + i};
    for (const Bond& bond : bonds[i]) found.push_back(first + bond.to);
    return found;
  }
  /// The particle with most bonds.
  std::size_t busiest() const {
    std::size_t best = 0;
    for (std::size_t i = 0; i < count; ++i)
      if (bonds[i].size() > bonds[best].size()) best = i;
    return best;
  }

private:
  void take_bonds(const Model& model) {
    bonds.resize(count);
    const LawConstants& constants = model.constants[0];
    const double modulus = constants.modulus * model.volume[0];
    const auto stiffness = [&](std::uint32_t b, double length2) {
      return rounded(modulus * model.bonds.weight[b] / length2);
    };
    for (std::uint32_t i = 0; i < count; ++i) {
      for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
        const std::uint32_t j = model.bonds.neighbour[b];
        const Vector3 steps =
            ((model.reference[j] - model.reference[i]) * reference_grid / spacing).array().round();
        const double length2 = (steps * spacing / reference_grid).squaredNorm();
        bonds[i].push_back(
            {j, steps * unit, stiffness(b, length2), stiffness(model.bonds.reverse[b], length2)});
      }
      inverse_modulus.push_back(bonds[i].empty() ? 0 : rounded(1 / modulus));
      coupling.push_back(rounded(constants.coupling));
      reference.push_back(model.reference[i]);
    }
  }

  void move(Random& random, bool coincident) {
    const Matrix3 turn = random.rotation().toRotationMatrix();
    const Matrix3 map =
        turn * (Matrix3::Identity() +
                0.2 * (Matrix3() << random.vector(), random.vector(), random.vector()).finished());
    for (std::uint32_t i = 0; i < count; ++i) {
      position.push_back(rounded(Vector3(map * reference[i] + random.vector(0.1 * spacing))));
      displacement.push_back(random.vector(0.1 * spacing));
    }
    const std::size_t i = busiest();
    if (!coincident || bonds[i].empty()) return;
    position[bonds[i][0].to] = position[i];
    displacement[bonds[i][0].to] = displacement[i];
  }

  // SELL-16: behind two rows that belong to other ranges, a row of 16 neighbours and 16 packed vectors.
  void pack() {
    std::vector<double> begin(first_slice + 1, 2.0), bond(64, 0.0), weight(64, not_a_number);
    for (std::uint32_t from = 0; from < count; from += slice_width) {
      const std::uint32_t end = std::min(from + slice_width, count);
      std::size_t row_count = 0;
      for (std::uint32_t i = from; i < end; ++i) row_count = std::max(row_count, bonds[i].size());
      for (std::size_t r = 0; r < row_count; ++r) {
        const std::size_t at = bond.size();
        bond.resize(at + 32, 0.0);
        weight.resize(at + 32, 0.0);
        for (std::uint32_t lane = 0; lane < slice_width; ++lane) {
          const std::uint32_t i = from + lane;
          bond[at + lane] = first + (i < end ? i : from);
          if (i >= end || r >= bonds[i].size()) continue;
          const Bond& entry = bonds[i][r];
          std::uint32_t word = 0;
          for (int axis = 0; axis < 3; ++axis)
            word |= (static_cast<std::uint32_t>(static_cast<int>(std::lround(entry.reference[axis] / unit))) &
                     1023u)
                    << (10 * axis);
          bond[at + lane] = static_cast<double>(first + entry.to);
          bond[at + 16 + lane] = word;
          weight[at + lane] = entry.out;
          weight[at + 16 + lane] = entry.in;
        }
      }
      begin.push_back(begin.back() + static_cast<double>(row_count));
    }
    bond_values = {{"first", {double(first)}},
                   {"first_slice", {double(first_slice)}},
                   {"unit", {unit}},
                   {"slice_begin", begin},
                   {"bond", bond},
                   {"weight", weight}};
  }
};

/// The rotation nearest to a matrix (determinant +1), the signed singular values, and how well it is
/// determined.
struct Polar {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 value = Vector3::Zero(); ///< signed: the last may be negative
  Matrix3 u = Matrix3::Identity(), v = Matrix3::Identity();
  double condition = anything; ///< error of the rotation, in roundings of the matrix
  explicit Polar(const Matrix3& m) {
    const Eigen::JacobiSVD<Matrix3> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    value = svd.singularValues();
    u = svd.matrixU();
    v = svd.matrixV();
    if ((u * v.transpose()).determinant() < 0) {
      value[2] = -value[2];
      u.col(2) = -u.col(2);
    }
    rotation = u * v.transpose();
    const double gap = value[1] + value[2];
    if (gap > 0.02 * value[0]) condition = value[0] / gap;
  }
};

struct Place {
  const char* buffer;
  std::size_t width = 1, component = 0; ///< reals a particle, and which of them
};

/// Spoils one input of the particle with most bonds.
template <class Args, class Problem>
void expect_nan_contained(const DeviceChoice& choice, Problem problem, const Place& input,
                          const Place& output) {
  const BondProblem& p = problem.p;
  Device& device = OpenDevices::of(choice);
  const Values clean = run_kernel<Args>(device, p.count, problem.in);
  const std::size_t at = p.busiest();
  ASSERT_GT(p.bonds[at].size(), 5u);
  problem.in[input.buffer][input.width * (p.first + at) + input.component] = not_a_number;
  const Values spoiled = run_kernel<Args>(device, p.count, problem.in);
  expect_contained(output.buffer, clean.at(output.buffer), spoiled.at(output.buffer), output.width,
                   p.reach(at), p.first + at);
}

template <class Args, class Problem>
void expect_nothing_when_stopped(const DeviceChoice& choice, Problem problem, const char* output) {
  problem.in["solver"][0] = 1;
  const Values out = run_kernel<Args>(OpenDevices::of(choice), problem.p.count, problem.in);
  compare_values(output, out.at(output), problem.in.at(output),
                 std::vector<double>(out.at(output).size(), 0.0), 0, 0);
}

inline const std::vector<double> solver_running(16, 0.0); ///< SOLVER_STOP is 0

} // namespace pliant::test
