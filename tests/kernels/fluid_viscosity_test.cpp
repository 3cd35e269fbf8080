// Implicit viscosity: its kernels one by one, and as a solver against a dense one.
#include "kernels/fluid_viscosity_apply.h"
#include "kernels/fluid_viscosity_begin.h"
#include "kernels/fluid_viscosity_control.h"
#include "kernels/fluid_viscosity_product.h"
#include "kernels/fluid_viscosity_update.h"
#include "shaders/common/fluid_viscosity.glsl"
#include "tests/support/bodies.h"
#include "tests/support/near_lists.h"

#include <Eigen/Dense>

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FluidViscosity);

namespace kernel = kernels;
using Begin = kernel::fluid_viscosity_begin::Args;
using Product = kernel::fluid_viscosity_product::Args;
using Control = kernel::fluid_viscosity_control::Args;
using Update = kernel::fluid_viscosity_update::Args;

// Two fluids of different viscosity and mass, one without any; if wanted, on a wall of ghosts below y = 0,
// and some in a nozzle, which does not move them: of them the fourth is a material, of ghosts a height.
NearCloud cloud_of(std::size_t count, bool ghosts, bool periodic) {
  Random random(kernel_seed + 201);
  NearCloud cloud;
  cloud.material(0, 2, 0, 0);
  cloud.material(1, 8, 0, 0);
  cloud.material(2, 0, 0, 0);
  const double d = cloud.spacing, size = 6 * d;
  if (periodic) cloud.period = {size, 0, size};
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 at = size / 2 * Vector3(1 + random(), 1 + random(), 1 + random());
    const bool ghost = ghosts && i % 4 == 0;
    const double depth = rounded((0.5 + (i % 8 == 0)) * d);
    if (ghost)
      cloud.add({at.x(), -depth, at.z()}, -0.25, -depth, random.vector());
    else if (ghosts && i % 9 == 5)
      cloud.add(at, -0.25, 1, random.vector());
    else
      cloud.add(at, i % 3 == 1 ? 0.5 : 0.25, static_cast<double>(i % 5 == 0 ? 2 : i % 2), random.vector());
  }
  return cloud;
}

constexpr double coupling = 0.0078125, least = 0.015625;

double rate_of(const NearCloud& c, std::size_t i, std::size_t j) {
  const double mu = c.trait(i, 1), theirs = c.mass[j] < 0 ? mu : c.trait(j, 1);
  const Vector3 d = c.between(i, j);
  double rate = mu + theirs > 0 ? coupling * 2 * mu * theirs / (mu + theirs) *
                                      (1 - d.norm() / c.support_in_float()) / c.mass[i]
                                : 0;
  if (c.mass[j] > 0) return rate;
  Vector3 away = Vector3::Zero();
  for (std::size_t g = 0; g < c.place.size(); ++g)
    if (c.mass[g] < 0 && c.between(i, g).norm() < c.support_in_float())
      away += (1 - c.between(i, g).norm() / c.support_in_float()) * c.between(i, g);
  const double depth = std::max(-c.fourth[j], 0.0);
  return rate * (1 + depth / std::max(d.dot(away.normalized()) - depth, least));
}

/// Where it was at the step's start, so that lines of centres are those of then.
Vector3 start_of(const NearCloud& c, std::size_t i) {
  const Vector3 at = c.place[i] - 0.0078125 * c.velocity[i];
  return {rounded(at.x()), rounded(at.y()), rounded(at.z())};
}
Vector3 arm_of(const NearCloud& c, std::size_t i, std::size_t j) {
  Vector3 d = start_of(c, i) - start_of(c, j);
  for (int a = 0; a < 3; ++a)
    if (c.period[a] > 0) d[a] -= c.period[a] * std::round(d[a] / c.period[a]);
  return d;
}
/// How much a rounding of places of this size is worth in an arm.
double arm_scale(const NearCloud& c, double arm) {
  return 1 + c.period.norm() / arm;
}

Values begin_values(const NearCloud& cloud, bool ghosts, bool central) {
  const std::size_t places = cloud.places();
  Values in = cloud.values();
  in["ghosts"] = {double(ghosts)}, in["mixed"] = {1}, in["central"] = {double(central)};
  in["fluid_start"] = std::vector<double>(4 * places, 0.0);
  for (std::size_t i = 0; i < cloud.place.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a)
      in["fluid_start"][4 * i + a] = start_of(cloud, i)[static_cast<Eigen::Index>(a)];
  in["coupling"] = {coupling};
  in["least_distance"] = {least};
  in["near_rate"] = std::vector<double>(in["near"].size(), sentinel);
  in["fluid_residual"] = guarded(std::vector<double>(4 * places, sentinel), 4);
  in["fluid_partial"] = std::vector<double>(4 * ((places + 127) / 128 + 1), sentinel);
  return in;
}

// The wall's normal comes from sums whose parts cancel, and a distance of a fraction of a spacing from places
// of ten spacings: some ten roundings each.
TEST_P(FluidViscosity, RatesAndFirstResidual) {
  for (const bool central : {false, true})
    for (const bool ghosts : {false, true})
      for (const bool periodic : {false, true})
        for (const std::size_t count : awkward_sizes) {
          if (count > 200) continue;
          const NearCloud cloud = cloud_of(count, ghosts, periodic);
          const Values in = begin_values(cloud, ghosts, central);
          const auto list = cloud.lists();
          Expected rate(in.at("near_rate")), residual(in.at("fluid_residual")),
              partial(in.at("fluid_partial"));
          const auto rows = static_cast<std::size_t>(in.at("rows")[0]);
          std::vector<double> sum(partial.value.size() / 4, 0.0);
          for (std::size_t i = 0; i < cloud.places(); ++i) {
            const auto longest = static_cast<std::size_t>(in.at("near_count")[i / 16]);
            const auto put = [&](std::size_t r, double value, double scale) {
              rate.set(16 * (rows * (i / 16) + r) + i % 16, value, scale);
            };
            for (std::size_t r = 0; r < longest; ++r) put(r, 0, 0);
            Vector3 u = Vector3::Zero(), scale = Vector3::Zero();
            const bool moves = i < count && cloud.mass[i] > 0;
            if (moves) {
              for (std::size_t r = 0; r < list[i].size(); ++r) {
                const std::uint32_t j = list[i][r];
                const double value = rate_of(cloud, i, j),
                             most = value + coupling * cloud.trait(i, 1) / cloud.mass[i];
                if (central) {
                  const Vector3 arm = arm_of(cloud, i, j), faster = cloud.velocity[j] - cloud.velocity[i];
                  const double square = arm.squaredNorm(), worse = arm_scale(cloud, arm.norm());
                  put(r, value / square, most / square * worse);
                  u += value / square * arm.dot(faster) * arm;
                  scale += Vector3::Constant(
                      most * worse * (cloud.velocity[j].cwiseAbs() + cloud.velocity[i].cwiseAbs()).norm());
                  continue;
                }
                put(r, value, most);
                u += value * (cloud.velocity[j] - cloud.velocity[i]);
                scale += most * (cloud.velocity[j].cwiseAbs() + cloud.velocity[i].cwiseAbs());
              }
              sum[i / 128] += cloud.mass[i] * cloud.velocity[i].squaredNorm();
            }
            set_vector(residual, i, u, scale);
            residual.set(4 * i + 3, moves ? cloud.mass[i] : 0);
          }
          for (std::size_t g = 0; g < (cloud.places() + 127) / 128; ++g) {
            partial.set(4 * g, sum[g], sum[g]);
            for (std::size_t k = 1; k < 4; ++k) partial.set(4 * g + k, 0);
          }
          expect_kernel<Begin>(
              GetParam(), static_cast<std::uint32_t>(cloud.places()), chosen<Begin>(in),
              {{"near_rate", rate}, {"fluid_residual", residual}, {"fluid_partial", partial}}, 25);
        }
}

TEST_P(FluidViscosity, Product) {
  for (const bool central : {false, true})
    for (const std::size_t count : awkward_sizes) {
      if (count > 200) continue;
      const NearCloud cloud = cloud_of(count, false, true);
      Values in = begin_values(cloud, false, central);
      Random random(kernel_seed + 202);
      const std::size_t places = cloud.places();
      in["near_rate"].resize(in["near"].size());
      for (double& rate : in["near_rate"]) rate = std::abs(random());
      in["fluid_residual"] = random_groups(random, places, 2);
      for (std::size_t i = 0; i < places; ++i) in["fluid_residual"][4 * i + 3] = std::abs(random());
      in["fluid_viscosity"] = std::vector<double>(VISCOSITY_ENTRIES, 0.0);
      in["fluid_image"] = guarded(std::vector<double>(4 * places, sentinel), 4);
      in["fluid_partial"] = std::vector<double>(4 * ((places + 127) / 128 + 1), sentinel);
      Expected image(in["fluid_image"]), partial(in["fluid_partial"]);
      const auto rows = static_cast<std::size_t>(in["rows"][0]);
      const std::vector<double>& u = in["fluid_residual"];
      std::vector<double> sums(4 * (places / 128 + 1), 0.0), sizes(sums);
      for (std::size_t i = 0; i < places; ++i) {
        Vector3 w = vector_at(u, i), scale = w.cwiseAbs();
        for (std::size_t r = 0; r < static_cast<std::size_t>(in["near_count"][i / 16]); ++r) {
          const std::size_t at = 16 * (rows * (i / 16) + r) + i % 16,
                            j = static_cast<std::size_t>(in["near"][at]);
          if (central) {
            if (j == i) continue;
            const Vector3 arm = arm_of(cloud, i, j);
            w += in["near_rate"][at] * arm.dot(vector_at(u, i) - vector_at(u, j)) * arm;
            scale +=
                Vector3::Constant(in["near_rate"][at] * arm.squaredNorm() * arm_scale(cloud, arm.norm()) *
                                  (vector_at(u, i).cwiseAbs() + vector_at(u, j).cwiseAbs()).norm());
            continue;
          }
          w += in["near_rate"][at] * (vector_at(u, i) - vector_at(u, j));
          scale += in["near_rate"][at] * (vector_at(u, i).cwiseAbs() + vector_at(u, j).cwiseAbs());
        }
        set_vector(image, i, w, scale);
        image.set(4 * i + 3, 0);
        const double mass = u[4 * i + 3],
                     products[] = {vector_at(u, i).squaredNorm(), vector_at(u, i).dot(w)};
        for (std::size_t k = 0; k < 2; ++k) {
          sums[4 * (i / 128) + k] += mass * products[k];
          sizes[4 * (i / 128) + k] +=
              mass * vector_at(u, i).cwiseAbs().dot(k == 0 ? vector_at(u, i).cwiseAbs() : scale);
        }
      }
      for (std::size_t k = 0; k < 4 * ((places + 127) / 128); ++k) partial.set(k, sums[k], sizes[k]);
      // Lists of up to some thirty, groups of 128.
      expect_kernel<Product>(GetParam(), static_cast<std::uint32_t>(places), chosen<Product>(in),
                             {{"fluid_image", image}, {"fluid_partial", partial}}, 8);
      in["fluid_viscosity"][VISCOSITY_STOP] = 1;
      expect_kernel<Product>(
          GetParam(), static_cast<std::uint32_t>(places), chosen<Product>(in),
          {{"fluid_image", Expected(in["fluid_image"])}, {"fluid_partial", Expected(in["fluid_partial"])}},
          0);
    }
}

using Changes = std::map<std::size_t, double>;
void expect_control(const DeviceChoice& choice, const char* name, bool start, double squares, double product,
                    const Changes& before, const Changes& changes) {
  SCOPED_TRACE(name);
  std::vector<double> entries{0, 3, 64, 4, 16, 0.5, 0.25, sentinel};
  for (const auto& [entry, value] : before) entries[entry] = value;
  Expected wanted(entries);
  for (const auto& [entry, value] : changes) wanted.set(entry, value, std::abs(value));
  expect_kernel<Control>(
      choice, 256,
      {{"start", {double(start)}},
       {"partial_count", {2}},
       {"cap", {20}},
       {"tolerance", {0.0625}},
       {"rounding", {0.03125}},
       {"fluid_partial", {squares - 1, product, 9, 9, 1, 0, 9, 9, sentinel, sentinel, 0, 0}},
       {"fluid_viscosity", entries}},
      {{"fluid_viscosity", wanted}}, 8);
}

TEST_P(FluidViscosity, Control) {
  const DeviceChoice& on = GetParam();
  expect_control(on, "start", true, 5, 0, {},
                 {{VISCOSITY_ITERATIONS, 0},
                  {VISCOSITY_FIRST, 0},
                  {VISCOSITY_LEFT, 0},
                  {VISCOSITY_SPEED, 5},
                  {VISCOSITY_STEP, 0},
                  {VISCOSITY_KEEP, 0}});
  expect_control(on, "first", false, 8, 16, {{VISCOSITY_ITERATIONS, 0}},
                 {{VISCOSITY_ITERATIONS, 1},
                  {VISCOSITY_FIRST, 8},
                  {VISCOSITY_LEFT, 8},
                  {VISCOSITY_STEP, 0.5},
                  {VISCOSITY_KEEP, 0}});
  expect_control(
      on, "goes on", false, 1, 3, {},
      {{VISCOSITY_ITERATIONS, 4}, {VISCOSITY_LEFT, 1}, {VISCOSITY_KEEP, 0.25}, {VISCOSITY_STEP, 1 / 2.5}});
  const auto stopped = [](double left) { return Changes{{VISCOSITY_STOP, 1}, {VISCOSITY_LEFT, left}}; };
  expect_control(on, "enough", false, 0.25, 3, {}, stopped(0.25));
  expect_control(on, "as little as rounding leaves", false, 0.5, 3, {{VISCOSITY_SPEED, 1024}}, stopped(0.5));
  expect_control(on, "the cap", false, 1, 3, {{VISCOSITY_ITERATIONS, 20}}, stopped(1));
  for (const double product : {0.25, -3.0, not_a_number, anything})
    expect_control(on, "no positive curvature", false, 1, product, {}, stopped(1));
  expect_control(on, "nothing to do", false, 0, 0, {{VISCOSITY_ITERATIONS, 0}},
                 {{VISCOSITY_STOP, 1}, {VISCOSITY_FIRST, 0}, {VISCOSITY_LEFT, 0}});
  expect_control(on, "done before", false, 1, 3, {{VISCOSITY_STOP, 1}}, {});
}

TEST_P(FluidViscosity, UpdateAndApply) {
  for (const std::size_t count : awkward_sizes)
    for (const double keep : {0.0, 0.375})
      for (const double stop : {0.0, 1.0}) {
        Random random(kernel_seed + 203);
        Values in;
        for (const char* name :
             {"fluid_image", "fluid_direction", "fluid_direction_image", "fluid_residual", "fluid_velocity"})
          in[name] = guarded(random_groups(random, count, 2), 4);
        for (std::size_t i = 0; i < count; ++i) in["fluid_residual"][4 * i + 3] = i % 4 == 1 ? 0 : 0.5;
        if (keep == 0)
          for (const char* name : {"fluid_direction", "fluid_direction_image"})
            std::fill(in[name].begin(), in[name].begin() + static_cast<std::ptrdiff_t>(4 * count),
                      not_a_number);
        in["fluid_viscosity"] = {stop, 1, 1, 1, 1, 0.625, keep, 0};
        Expected p(in["fluid_direction"]), image(in["fluid_direction_image"]), u(in["fluid_residual"]),
            v(in["fluid_velocity"]);
        for (std::size_t i = 0; i < count && stop == 0; ++i) {
          for (std::size_t k = 4 * i; k < 4 * i + 3; ++k) {
            const auto with = [&](double value, const char* last) {
              return keep == 0 ? value : value + keep * in[last][k];
            };
            const double pk = with(in["fluid_residual"][k], "fluid_direction"),
                         sk = with(in["fluid_image"][k], "fluid_direction_image");
            p.set(k, pk, 2), image.set(k, sk, 2);
            if (i % 4 == 1) continue;
            u.set(k, u.value[k] - 0.625 * sk, 4), v.set(k, v.value[k] + 0.625 * pk, 4);
          }
          p.set(4 * i + 3, 0), image.set(4 * i + 3, 0);
        }
        const auto threads = static_cast<std::uint32_t>(count);
        expect_kernel<Update>(GetParam(), threads, in,
                              {{"fluid_direction", p},
                               {"fluid_direction_image", image},
                               {"fluid_residual", u},
                               {"fluid_velocity", v}},
                              4);
        Values flight{{"time_step", {0.25}},
                      {"fluid_start", in["fluid_image"]},
                      {"fluid_velocity", in["fluid_velocity"]},
                      {"fluid_place", in["fluid_residual"]}};
        Expected at(flight["fluid_place"]);
        for (std::size_t i = 0; i < count; ++i)
          for (std::size_t k = 4 * i; k < 4 * i + 3 && i % 4 != 1; ++k)
            at.set(k, in["fluid_image"][k] + 0.25 * in["fluid_velocity"][k], 2);
        expect_kernel<kernel::fluid_viscosity_apply::Args>(GetParam(), threads, flight, {{"fluid_place", at}},
                                                           2);
      }
}

struct Solved {
  std::vector<double> velocity, entries;
};
Solved solve(Device& device, const NearCloud& cloud, bool ghosts, bool central, double tolerance, double cap,
             double rounding) {
  const auto places = static_cast<std::uint32_t>(cloud.places());
  Values all = begin_values(cloud, ghosts, central);
  const std::size_t groups = (places + 127) / 128;
  all["partial_count"] = {double(groups)};
  all["cap"] = {cap}, all["tolerance"] = {tolerance}, all["rounding"] = {rounding};
  all["fluid_viscosity"] = std::vector<double>(VISCOSITY_ENTRIES, 0.0);
  for (const char* name : {"fluid_image", "fluid_direction", "fluid_direction_image"})
    all[name] = std::vector<double>(4 * std::size_t{places}, 0.0);
  const auto keep = [&](const Values& got) {
    for (const auto& [name, values] : got) all[name] = values;
  };
  keep(run_kernel<Begin>(device, places, chosen<Begin>(all)));
  keep(run_kernel<Control>(device, 256, chosen<Control>(all, {{"start", {1}}})));
  for (double k = 0; k <= cap && all["fluid_viscosity"][VISCOSITY_STOP] == 0; ++k) {
    keep(run_kernel<Product>(device, places, chosen<Product>(all)));
    keep(run_kernel<Control>(device, 256, chosen<Control>(all)));
    keep(run_kernel<Update>(device, places, chosen<Update>(all)));
  }
  return {all["fluid_velocity"], all["fluid_viscosity"]};
}

TEST_P(FluidViscosity, AgreesWithADenseSolve) {
  for (const bool central : {false, true})
    for (const bool ghosts : {false, true}) {
      const NearCloud cloud = cloud_of(200, ghosts, true);
      const auto n = static_cast<Eigen::Index>(cloud.place.size());
      Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * n, 3 * n);
      Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * n);
      const auto list = cloud.lists();
      for (Eigen::Index i = 0; i < n; ++i) {
        const auto row = static_cast<std::size_t>(i);
        const double mass = std::abs(cloud.mass[row]);
        a.block<3, 3>(3 * i, 3 * i) = mass * Eigen::Matrix3d::Identity();
        right.segment<3>(3 * i) = mass * cloud.velocity[row];
        if (cloud.mass[row] < 0) continue;
        for (const std::uint32_t j : list[row]) {
          const Vector3 n_ij = arm_of(cloud, row, j).normalized();
          const Eigen::Matrix3d form =
              central ? Eigen::Matrix3d(n_ij * n_ij.transpose()) : Eigen::Matrix3d::Identity();
          const Eigen::Matrix3d share = mass * rate_of(cloud, row, j) * form;
          a.block<3, 3>(3 * i, 3 * i) += share;
          a.block<3, 3>(3 * i, 3 * static_cast<Eigen::Index>(j)) -= share;
        }
      }
      if (!ghosts) {
        expect_below("matrix less its transpose", (a - a.transpose()).cwiseAbs().maxCoeff(), 1e-14);
        const Eigen::VectorXd eigenvalues =
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
        expect_above("least eigenvalue, kg (the least mass is .25)", eigenvalues.minCoeff(), 0.25 - 1e-12);
        report("largest eigenvalue, kg", eigenvalues.maxCoeff());
      }
      const Eigen::VectorXd exact = a.partialPivLu().solve(right);
      const bool is_double = GetParam().precision == Precision::double_precision;
      const Solved found = solve(OpenDevices::of(GetParam()), cloud, ghosts, central,
                                 is_double ? 1e-12 : 1e-6, 200, is_double ? 1e-15 : 5e-7);
      double worst = 0;
      for (Eigen::Index i = 0; i < n; ++i)
        worst = std::max(
            worst, (vector_at(found.velocity, static_cast<std::size_t>(i)) - Vector3(exact.segment<3>(3 * i)))
                       .norm());
      report("iterations", found.entries[VISCOSITY_ITERATIONS]);
      EXPECT_LT(found.entries[VISCOSITY_ITERATIONS], 200);
      // The rms of the first residual is about 1 m/s, that of one particle 200^(1/2) of it at most; float:
      // 1e-6 of it.
      expect_below("velocity less that of a dense solve, m/s", worst, is_double ? 1e-11 : 2e-5);
    }
}

// Whatever the number of iterations; of central forces the angular one about any point too.
TEST_P(FluidViscosity, MomentumIsKept) {
  for (const bool central : {false, true}) {
    const NearCloud cloud = cloud_of(300, false, false);
    const auto sums = [&](const auto& velocity) {
      std::array<Vector3, 2> sum{Vector3::Zero(), Vector3::Zero()};
      for (std::size_t i = 0; i < cloud.place.size(); ++i) {
        sum[0] += cloud.mass[i] * velocity(i);
        sum[1] += cloud.mass[i] * start_of(cloud, i).cross(velocity(i));
      }
      return sum;
    };
    const auto before = sums([&](std::size_t i) { return cloud.velocity[i]; });
    double size = 0, turning = 0;
    for (std::size_t i = 0; i < cloud.place.size(); ++i) {
      size += cloud.mass[i] * cloud.velocity[i].norm();
      turning += cloud.mass[i] * cloud.velocity[i].norm() * start_of(cloud, i).norm();
    }
    for (const double cap : {0., 1., 2., 5.}) {
      const Solved found = solve(OpenDevices::of(GetParam()), cloud, false, central, 0, cap, 0);
      EXPECT_EQ(found.entries[VISCOSITY_ITERATIONS], cap);
      const auto after = sums([&](std::size_t i) { return vector_at(found.velocity, i); });
      // Each of 300 velocities is rounded a few times an iteration, about as often up as down.
      expect_below("change of momentum over the sum of its magnitudes", (after[0] - before[0]).norm() / size,
                   GetParam().epsilon());
      const double turn = (after[1] - before[1]).norm() / turning;
      if (central)
        expect_below("change of angular momentum over that sum", turn, GetParam().epsilon());
      else if (cap > 0)
        expect_above("change of angular momentum over that sum", turn, 1e-3);
    }
  }
}

// A block that spins as a whole: central forces do not feel it.
TEST_P(FluidViscosity, FreeSpinning) {
  NearCloud cloud = cloud_of(300, false, false);
  const Vector3 spin(0.5, -1, 2);
  for (int k = 0; k < 60; ++k) // where it starts from depends on the velocity
    for (std::size_t i = 0; i < cloud.place.size(); ++i) cloud.velocity[i] = spin.cross(start_of(cloud, i));
  double left[2] = {0, 0}, size = 0;
  for (const bool central : {false, true}) {
    const Solved found = solve(OpenDevices::of(GetParam()), cloud, false, central, 1e-6, 50, 0);
    for (std::size_t i = 0; i < cloud.place.size(); ++i) {
      left[central] += (vector_at(found.velocity, i) - cloud.velocity[i]).squaredNorm();
      if (central) size += cloud.velocity[i].squaredNorm();
    }
  }
  expect_below("change by central forces, of the velocity", std::sqrt(left[1] / size),
               64 * GetParam().epsilon());
  expect_above("by the other form", std::sqrt(left[0] / size), 0.03);
}

TEST_P(FluidViscosity, RelativeMotionDecaysAndTogetherNothingHappens) {
  NearCloud cloud = cloud_of(200, true, true);
  for (std::size_t i = 0; i < cloud.place.size(); ++i) cloud.velocity[i] = {1, -2, 0.5};
  for (const bool central : {false, true}) {
    const Solved together = solve(OpenDevices::of(GetParam()), cloud, true, central, 1e-6, 50, 0);
    EXPECT_EQ(together.entries[VISCOSITY_ITERATIONS], 0);
    for (std::size_t i = 0; i < cloud.place.size(); ++i)
      EXPECT_EQ(vector_at(together.velocity, i), Vector3(1, -2, 0.5));
  }
}

TEST(FluidViscosityThreads, SameBits) {
  const NearCloud cloud = cloud_of(1500, true, true);
  for (const bool central : {false, true}) {
    std::vector<std::vector<double>> found;
    for (const unsigned threads : {1u, 2u}) {
      const std::unique_ptr<Device> device =
          open_alone({"openmp_float", "openmp", Precision::single_precision}, threads);
      found.push_back(solve(*device, cloud, true, central, 1e-5, 50, 0).velocity);
    }
    EXPECT_EQ(found[0], found[1]);
  }
}

} // namespace
} // namespace pliant::test
