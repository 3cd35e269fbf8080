// The wide bodies of the corotated law against its formulas written out with Eigen in double: every count of
// particles around a slice and a register, ranges that begin anywhere, flat and inverted neighbourhoods.
#include "backends/openmp/device.h"
#include "kernels/corotated_force.h"
#include "kernels/corotated_state.h"
#include "shaders/common/solver.glsl"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

namespace pliant::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Values = std::vector<Real4<double>>;

constexpr double sentinel = -12345, unit = 0.01 / 120;
constexpr std::uint32_t before = 5, after = 9; // particles of other laws around the range

/// The rotation that maximises tr(R^T S).
Matrix3d nearest_rotation(const Matrix3d& s) {
  const Eigen::JacobiSVD<Matrix3d> svd(s, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

struct Bond {
  std::uint32_t neighbour = 0;
  int code[3] = {};
  double out = 0, in = 0;
  Vector3d vector() const { return unit * Vector3d(code[0], code[1], code[2]); }
};

/// `count` particles of the law, all in all before + count + after; numbers that a float holds exactly.
struct Problem {
  std::uint32_t count, all;
  std::vector<std::vector<Bond>> bonds;
  Values displacement, rotation, linear_start;
  std::vector<double> shape;

  /// squash: the smallest singular value of most neighbourhoods; negative is inverted.
  Problem(std::uint32_t particles, double squash, unsigned seed)
      : count(particles), all(before + particles + after), bonds(particles), displacement(all), rotation(all),
        linear_start(all), shape(std::size_t{11} * all) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const auto small = [&](double size) {
      return static_cast<double>(static_cast<float>(size) * uniform(random));
    };
    for (std::uint32_t i = 0; i < all; ++i) {
      displacement[i] = {small(1e-3), small(1e-3), small(1e-3), 0};
      rotation[i] = {0, 0, 0, 1};
      linear_start[i] = {small(1), small(1), small(1), 7};
      shape[i] = 1;
      shape[all + i] = 1.5;
      const Eigen::AngleAxisd turn(0.6, Vector3d(1, 2, uniform(random)).normalized());
      const Matrix3d s = turn.toRotationMatrix() * Vector3d(1.25, 0.75, squash).asDiagonal();
      for (std::uint32_t e = 0; e < 9; ++e)
        shape[(e + 2) * std::size_t{all} + i] = static_cast<float>(s(e / 3, e % 3));
    }
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::uint32_t b = 0; b < (i * 7) % 11; ++b) {
        Bond bond{static_cast<std::uint32_t>(random() % all), {}, 0.5 + static_cast<double>(b) / 16, 0.75};
        for (int& code : bond.code) code = static_cast<int>(random() % 1023) - 511;
        bonds[i].push_back(bond);
      }
  }
};

struct Result {
  Values rotation, record, force;
};

Result run(Device& device, const Problem& p) {
  const std::uint32_t slices = (p.count + 15) / 16;
  std::vector<std::uint32_t> begin{0, 0}, bond; // one empty slice before the range
  std::vector<double> weight;
  for (std::uint32_t s = 0; s < slices; ++s) {
    std::size_t rows = 0;
    for (std::uint32_t i = 16 * s; i < std::min(16 * s + 16, p.count); ++i)
      rows = std::max(rows, p.bonds[i].size());
    for (std::size_t r = 0; r < rows; ++r) {
      const std::size_t at = bond.size();
      bond.resize(at + 32);
      weight.resize(at + 32);
      for (std::uint32_t lane = 0; lane < 16; ++lane) {
        const std::uint32_t i = std::min(16 * s + lane, p.count - 1);
        bond[at + lane] = before + i;
        if (16 * s + lane >= p.count || r >= p.bonds[i].size()) continue;
        const Bond& b = p.bonds[i][r];
        bond[at + lane] = b.neighbour;
        for (int axis = 0; axis < 3; ++axis)
          bond[at + 16 + lane] |= (static_cast<std::uint32_t>(b.code[axis]) & 1023U) << (10 * axis);
        weight[at + lane] = b.out;
        weight[at + 16 + lane] = b.in;
      }
    }
    begin.push_back(static_cast<std::uint32_t>(bond.size() / 32));
  }
  const auto put = [&](Type type, const auto& values) {
    Buffer buffer = device.allocate("input", type, std::max<std::size_t>(values.size(), 1));
    device.upload(buffer, values);
    return buffer;
  };
  const auto slice_begin = put(Type::uint, begin), bonds = put(Type::uint, bond),
             weights = put(Type::real, weight);
  const auto displacement = put(Type::real4, p.displacement), rotation = put(Type::real4, p.rotation);
  const auto shape = put(Type::real, p.shape), linear = put(Type::real4, p.linear_start);
  const auto solver = put(Type::real, std::vector<double>(SOLVER_ENTRIES, 0));
  const Real4<double> mark{sentinel, sentinel, sentinel, sentinel};
  Values records(std::size_t{3} * p.all, mark);
  const auto record = put(Type::real4, records), force = put(Type::real4, Values(p.all, mark));
  device.run(kernels::corotated_state::Args{.threads = p.count,
                                            .first = before,
                                            .first_slice = 1,
                                            .stride = p.all,
                                            .unit = unit,
                                            .slice_begin = slice_begin,
                                            .bond = bonds,
                                            .weight = weights,
                                            .displacement = displacement,
                                            .shape = shape,
                                            .rotation = rotation,
                                            .record = record,
                                            .solver = solver});
  Result result{device.download_real4(rotation), device.download_real4(record), {}};
  records = result.record; // of neighbours outside the range: something finite
  for (std::uint32_t i = 0; i < p.all; ++i)
    if (i < before || i >= before + p.count)
      for (std::uint32_t r = 0; r < 3; ++r) records[std::size_t{3} * i + r] = {0.25, 0.5, -0.5, 0.125};
  device.upload(record, records);
  device.run(kernels::corotated_force::Args{.threads = p.count,
                                            .first = before,
                                            .first_slice = 1,
                                            .unit = unit,
                                            .slice_begin = slice_begin,
                                            .bond = bonds,
                                            .weight = weights,
                                            .record = record,
                                            .linear_start = linear,
                                            .force = force,
                                            .solver = solver});
  result.force = device.download_real4(force);
  for (std::uint32_t i = 0; i < p.all; ++i) {
    const bool inside = i >= before && i < before + p.count;
    EXPECT_EQ(result.force[i].x == sentinel, !inside) << i;
    EXPECT_EQ(result.record[std::size_t{3} * i].x == sentinel, !inside) << i;
    EXPECT_TRUE(inside || result.rotation[i].w == 1) << i;
  }
  result.record = records;
  return result;
}

/// Largest error, checked against the limit.
double expect_law(const Problem& p, const Result& result, double limit) {
  const auto row = [&](std::uint32_t i, std::uint32_t r) { return result.record[std::size_t{3} * i + r]; };
  const auto matrix = [&](std::uint32_t i) {
    Matrix3d a;
    for (std::uint32_t r = 0; r < 3; ++r) a.row(r) << row(i, r).x, row(i, r).y, row(i, r).z;
    return a;
  };
  const auto shift = [&](std::uint32_t i) { return Vector3d(row(i, 0).w, row(i, 1).w, row(i, 2).w); };
  const auto u = [&](std::uint32_t i) {
    return Vector3d(p.displacement[i].x, p.displacement[i].y, p.displacement[i].z);
  };
  double worst = 0;
  for (std::uint32_t local = 0; local < p.count; ++local) {
    const std::uint32_t i = before + local;
    Matrix3d s;
    for (int e = 0; e < 9; ++e) s(e / 3, e % 3) = p.shape[static_cast<std::size_t>(e + 2) * p.all + i];
    Vector3d force(p.linear_start[i].x, p.linear_start[i].y, p.linear_start[i].z);
    for (const Bond& b : p.bonds[local]) {
      s += b.out * (u(b.neighbour) - u(i)) * b.vector().transpose();
      force += (b.out + b.in) * (shift(b.neighbour) - shift(i)) -
               (b.out * matrix(i) + b.in * matrix(b.neighbour)) * b.vector();
    }
    const Matrix3d r = nearest_rotation(s);
    const double theta = (r.array() * s.array()).sum();
    const double off = (matrix(i) - (1 - 1.5 * (theta - 1)) * r).norm();
    EXPECT_LT(off, limit) << "record " << local << " of " << p.count;
    EXPECT_LT((shift(i) - u(i)).norm(), 1e-9) << local;
    const auto& f = result.force[i];
    const double missing = (Vector3d(f.x, f.y, f.z) - force).norm();
    EXPECT_LT(missing, limit) << "force " << local << " of " << p.count;
    worst = std::max({worst, off, missing});
    EXPECT_EQ(f.w, 7);
  }
  return worst;
}

// Rounding over ten bonds and one decomposition: 1.2e-6 and 1.8e-14 were seen.
TEST(CorotatedWide, FollowsTheLaw) {
  for (const auto& [precision, limit] :
       {std::pair{Precision::single_precision, 1e-5}, std::pair{Precision::double_precision, 1e-13}}) {
    const auto device = openmp::make_device(precision, 2);
    double worst = 0;
    for (const std::uint32_t count : {1, 3, 4, 5, 8, 15, 16, 17, 31, 100})
      for (const double squash : {0.9, 0.0, -0.4}) {
        const Problem problem(count, squash, 42 + count);
        worst = std::max(worst, expect_law(problem, run(*device, problem), limit));
      }
    std::printf("worst error %.1e, limit %.0e\n", worst, limit);
  }
}

TEST(CorotatedWide, SameBitsForAnyNumberOfThreads) {
  const Problem problem(2000, 0.3, 7);
  const auto one = openmp::make_device(Precision::single_precision, 1);
  const auto three = openmp::make_device(Precision::single_precision, 3);
  const Result a = run(*one, problem), b = run(*three, problem);
  for (std::size_t i = 0; i < a.force.size(); ++i) {
    ASSERT_EQ(a.force[i].x, b.force[i].x) << i;
    ASSERT_EQ(a.force[i].y, b.force[i].y) << i;
    ASSERT_EQ(a.rotation[i].z, b.rotation[i].z) << i;
  }
}

} // namespace
} // namespace pliant::test
