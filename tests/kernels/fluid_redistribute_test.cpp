// Redistribution of a fluid's particles and surface tension: kernels one by one, and what ten iterations do
// to a jittered block.
#include "kernels/fluid_gradient.h"
#include "kernels/fluid_gradient_sum.h"
#include "kernels/fluid_newton.h"
#include "kernels/fluid_redistribute.h"
#include "shaders/common/fluid_viscosity.glsl"
#include "shaders/common/spread.glsl"
#include "tests/support/bodies.h"
#include "tests/support/near_lists.h"

#include <numeric>

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FluidRedistribute);

using Gradient = kernels::fluid_gradient::Args;
using Newton = kernels::fluid_newton::Args;
using Redistribute = kernels::fluid_redistribute::Args;

// Two materials, ghosts, and a place where nothing is; the surface of a cube, and the inside.
NearCloud cloud_of(bool periodic, bool mixed = true) {
  NearCloud cloud = jittered_cube(6, 0.25, kernel_seed + 211);
  cloud.material(0, 0, 0.75, 0.5);
  cloud.material(1, 0, 0.25, 0);
  for (std::size_t i = 0; i < cloud.place.size(); ++i) {
    if (i % 3 == 0) cloud.fourth[i] = 1, cloud.mass[i] = mixed ? 0.5 : 0.25;
    if (cloud.place[i].y() < -2 * cloud.spacing) cloud.mass[i] = -0.25, cloud.fourth[i] = 0.03125;
  }
  cloud.mass[100] = 0;
  if (periodic) cloud.period = {6 * cloud.spacing, 0, 6 * cloud.spacing};
  return cloud;
}

double lattice_cover(const NearCloud& c) {
  return c.smoothing().lattice_sum(
             c.spacing, [&](double r) { return r > 0 ? -r * c.smoothing().spline_derivative(r) : 0; }) *
         c.volume() / c.dimension;
}

Values values_of(const NearCloud& c) {
  const Smoothing s = c.smoothing();
  const double volume = c.volume();
  Values in = c.values();
  in["spacing"] = {c.spacing};
  in["spiky_scale"] = in["slope_scale"] = {rounded(volume * s.spiky_gradient())};
  in["curvature_scale"] = {rounded(volume * s.spiky_gradient())};
  in["normal_scale"] = {rounded(s.support * volume * s.spline_gradient())};
  in["cover_scale"] = {rounded(volume * s.spline_gradient() / c.dimension / lattice_cover(c))};
  in["rate"] = {rounded(0.1 * s.support * s.support)};
  in["limit"] = {rounded(0.1 * c.spacing)};
  in["softness"] = {rounded(0.01 * std::pow(c.spacing, -4))};
  for (const char* name : {"fluid_gradient", "fluid_normal", "fluid_newton", "fluid_shift"})
    in[name] = guarded(std::vector<double>(4 * c.places(), sentinel), 4);
  return in;
}

// What a factor lost when it was made exact in float: derivatives are those of engine/model/smoothing.h
// otherwise.
double kept(double factor) {
  return rounded(factor) / factor;
}
Vector3 spiky_gradient(const NearCloud& c, const Vector3& d) {
  const Smoothing s = c.smoothing();
  const double r = d.norm(), factor = c.volume() * s.spiky_gradient();
  return kept(factor) * c.volume() * s.spiky_derivative(r) / std::max(r, 0.05 * s.support) * d;
}
Matrix3 spiky_hessian(const NearCloud& c, const Vector3& d) {
  const Smoothing s = c.smoothing();
  const double r = d.norm(), slope = s.spiky_derivative(r) / std::max(r, 0.05 * s.support);
  const double curvature = 6 * s.spiky() / (s.support * s.support) * (1 - r / s.support);
  const Matrix3 along = d * d.transpose() / (r * r);
  return kept(c.volume() * s.spiky_gradient()) * c.volume() *
         (curvature * along + slope * (Matrix3::Identity() - along));
}

// Places of ten spacings are rounded, and a pair's terms by their difference: some five roundings of the
// terms.
TEST_P(FluidRedistribute, GradientAndNormal) {
  for (const bool periodic : {false, true})
    for (const bool fickian : {false, true}) {
      const NearCloud c = cloud_of(periodic);
      const Smoothing s = c.smoothing();
      Values in = values_of(c);
      in["fickian"] = {double(fickian)};
      in["tension"] = {double(periodic)};
      const auto list = c.lists();
      Expected gradient(in["fluid_gradient"]), normal(in["fluid_normal"]);
      std::size_t surface = 0, inside = 0, cut = 0;
      for (std::size_t i = 0; i < c.places(); ++i) {
        Vector3 g = Vector3::Zero(), n = g, g_scale = g, n_scale = g;
        double cover = 0, mark = 2, nearest = 0;
        if (i < c.place.size() && c.mass[i] > 0) {
          nearest = c.support_in_float();
          for (const std::uint32_t j : list[i]) {
            nearest = std::min(nearest, c.between(i, j).norm());
            const Vector3 d = c.between(i, j), each = spiky_gradient(c, d);
            const double factor = s.support * c.volume() * s.spline_gradient();
            const double slope =
                kept(factor) * s.support * c.volume() * s.spline_derivative(d.norm()) / d.norm();
            g += each, g_scale += each.cwiseAbs();
            n += slope * d, n_scale += std::abs(slope) * d.cwiseAbs();
            cover -= slope * d.squaredNorm() / s.support / c.dimension / lattice_cover(c);
          }
          mark = c.trait(i, 2);
          const double far = in["rate"][0] * g.norm();
          if (fickian && mark * far > in["limit"][0]) mark = in["limit"][0] / far, ++cut;
          const bool at_surface = cover < SURFACE_COVER;
          ASSERT_GT(std::abs(cover - SURFACE_COVER), 1e-5) << "another seed: " << i;
          if (at_surface)
            mark = -mark, n /= std::max(1., n.norm());
          else
            n.setZero(), n_scale.setZero();
          ++(at_surface ? surface : inside);
        }
        set_vector(gradient, i, g, g_scale);
        gradient.set(4 * i + 3, periodic ? nearest : 0, nearest);
        set_vector(normal, i, n, n_scale);
        normal.set(4 * i + 3, mark, 1 + g_scale.norm() * in["rate"][0] / in["limit"][0]);
      }
      EXPECT_GT(surface, periodic ? 10u : 100u);
      EXPECT_GT(inside, 20u);
      EXPECT_EQ(cut > 20, fickian);
      expect_kernel<Gradient>(GetParam(), static_cast<std::uint32_t>(c.places()), chosen<Gradient>(in),
                              {{"fluid_gradient", gradient}, {"fluid_normal", normal}}, 18);
    }
}

// Values as fluid_gradient leaves them, exact in float.
void after_gradient(const NearCloud& c, Values& in) {
  in["fickian"] = {1}, in["tension"] = {1};
  Device& device = OpenDevices::of(device_choices().front());
  for (const auto& [name, values] :
       run_kernel<Gradient>(device, static_cast<std::uint32_t>(c.places()), chosen<Gradient>(in)))
    in[name] = values;
}

TEST_P(FluidRedistribute, NewtonMultipliers) {
  const NearCloud c = cloud_of(true);
  Values in = values_of(c);
  after_gradient(c, in);
  in["rate"] = {0.25};
  in["limit"] = {rounded(0.01 * c.spacing)};
  const auto list = c.lists();
  Expected newton(in["fluid_newton"]);
  std::size_t cut = 0, whole = 0;
  for (std::size_t i = 0; i < c.places(); ++i) {
    const Vector3 g = vector_at(in["fluid_gradient"], i);
    const double mark = std::abs(in["fluid_normal"][4 * i + 3]);
    double tau = 0, scale = 0;
    if (i < c.place.size() && c.mass[i] > 0) {
      Vector3 own = Vector3::Zero(), terms = own;
      double squares = 0;
      for (const std::uint32_t j : list[i]) {
        const Vector3 h = spiky_hessian(c, c.between(i, j)) * g;
        own += h, terms += h.cwiseAbs();
        if (c.mass[j] > 0) squares += h.squaredNorm();
      }
      const double all = own.squaredNorm() + squares + in["softness"][0] * g.squaredNorm();
      tau = g.squaredNorm() / all;
      const double alone = tau * own.norm(), share = std::min(0.25 * mark, in["limit"][0] / alone);
      ++(share < 0.25 * mark ? cut : whole);
      tau *= share;
      scale = tau * (1 + (terms.squaredNorm() + squares) / all + terms.norm() / own.norm());
    }
    set_vector(newton, i, tau * g, scale * g.cwiseAbs());
    newton.set(4 * i + 3, tau, scale);
  }
  EXPECT_GT(cut, 5u);
  EXPECT_GT(whole, 20u);
  expect_kernel<Newton>(GetParam(), static_cast<std::uint32_t>(c.places()), chosen<Newton>(in),
                        {{"fluid_newton", newton}}, 5);
}

TEST_P(FluidRedistribute, Shifts) {
  for (const bool periodic : {false, true})
    for (const int form : {0, 1, 2})
      for (const unsigned options : {0u, 1u, 2u, 3u}) {
        const bool tension = options & 1, mixed = options & 2;
        const NearCloud c = cloud_of(periodic, mixed);
        Values in = values_of(c);
        in["mixed"] = {double(mixed)};
        after_gradient(c, in);
        Random random(kernel_seed + 212);
        in["fluid_newton"] = random_groups(random, c.places(), 1e-6);
        in["form"] = {double(form)}, in["tension"] = {double(tension)};
        const double rate = in["rate"][0] = form == 0 ? in["rate"][0] : 100;
        in["pull"] = {rounded(0.25 * c.spacing)};
        const auto list = c.lists();
        Expected shift(in["fluid_shift"]);
        for (std::size_t i = 0; i < c.places(); ++i) {
          const Vector3 from = vector_at(in["fluid_place"], i);
          Vector3 all = Vector3::Zero(), scale = from.cwiseAbs();
          if (i < c.place.size() && c.mass[i] > 0) {
            const auto mark = [&](std::size_t j) { return in["fluid_normal"][4 * j + 3]; };
            Vector3 mean = vector_at(in["fluid_normal"], i);
            double weights = mark(i) < 0 ? 1 : 0;
            for (const std::uint32_t j : list[i])
              if (mark(j) < 0) {
                const double weight = 1 - c.between(i, j).norm() / c.support_in_float();
                mean += weight * vector_at(in["fluid_normal"], j), weights += weight;
              }
            for (const std::uint32_t j : list[i]) {
              const Vector3 d = c.between(i, j);
              const double other = std::abs(c.mass[j]), share = 2 * other / (c.mass[i] + other), r = d.norm();
              const Vector3 slope = spiky_gradient(c, d);
              Vector3 each;
              if (form == 0) {
                each = -rate * std::min(std::abs(mark(i)), std::abs(mark(j))) * slope;
                if (weights > 0)
                  each *= std::clamp((SPREAD_FAR - r / c.spacing) / (SPREAD_FAR - SPREAD_NEAR), 0., 1.);
              } else if (form == 1) {
                each = -spiky_hessian(c, d) *
                       (vector_at(in["fluid_newton"], i) - vector_at(in["fluid_newton"], j));
              } else {
                each = rate * 0.5 * (in["fluid_newton"][4 * i + 3] + in["fluid_newton"][4 * j + 3]) * slope;
              }
              if (tension && r < SPREAD_APART * c.spacing)
                each += SPREAD_APART_RATE * (SPREAD_APART * c.spacing - r) / r * d;
              all += share * each;
              scale += 4 * share * Vector3::Constant(each.norm());
            }
            if (weights > 0) {
              mean /= weights;
              all -=
                  std::min(mean.norm() / SURFACE_FULL, 1.) * mean.normalized().dot(all) * mean.normalized();
            }
            if (tension) all += in["pull"][0] * c.trait(i, 3) * vector_at(in["fluid_normal"], i);
          }
          set_vector(shift, i, from + all, scale);
          shift.set(4 * i + 3, in["fluid_place"][4 * i + 3]);
        }
        expect_kernel<Redistribute>(GetParam(), static_cast<std::uint32_t>(c.places()),
                                    chosen<Redistribute>(in), {{"fluid_shift", shift}}, 4);
      }
}

// Of a surface and of particles in one place: finite, opposite, and of the sum of nothing.
TEST_P(FluidRedistribute, ParticlesInOnePlacePart) {
  NearCloud c;
  c.material(0, 0, 1, 0);
  for (int k = 0; k < 2; ++k) c.add({0.5, 0.25, 0.125}, 0.25, 0, {0, 0, 0});
  Values in = values_of(c);
  after_gradient(c, in);
  in["tension"] = {1}, in["form"] = {0}, in["pull"] = {0};
  const std::vector<double> got =
      run_kernel<Redistribute>(OpenDevices::of(GetParam()), 16, chosen<Redistribute>(in)).at("fluid_shift");
  const Vector3 a = vector_at(got, 0) - c.place[0], b = vector_at(got, 1) - c.place[1];
  EXPECT_NEAR(a.norm(), SPREAD_APART * SPREAD_APART_RATE * c.spacing, 1e-6);
  EXPECT_NEAR((a + b).norm(), 0, 1e-7);
}

TEST_P(FluidRedistribute, Sums) {
  Random random(kernel_seed + 213);
  for (const std::size_t count : awkward_sizes) {
    Values in;
    in["spread"] = {1}, in["viscous"] = {1}, in["row"] = {1}, in["support"] = {0.5};
    in["place_count"] = {double(count)};
    in["fluid_gradient"] = guarded(random_groups(random, count, 3), 4);
    in["fluid_normal"] = guarded(random_groups(random, count, 1), 4);
    double inside = 0, uneven = 0, surface = 0;
    for (std::size_t i = 0; i < count; ++i) {
      double& mark = in["fluid_normal"][4 * i + 3];
      if (i % 5 == 0) mark = 2;
      if (mark < 0)
        ++surface;
      else if (mark <= 1)
        ++inside, uneven += 0.25 * vector_at(in["fluid_gradient"], i).squaredNorm();
    }
    in["fluid_viscosity"] = std::vector<double>(VISCOSITY_ENTRIES, 0.0);
    in["fluid_viscosity"][VISCOSITY_ITERATIONS] = 7;
    in["fluid_viscosity"][VISCOSITY_FIRST] = 16;
    in["fluid_viscosity"][VISCOSITY_LEFT] = 0.25;
    in["spread_row"] = std::vector<double>(24, sentinel);
    Expected row(in["spread_row"]);
    row.set(8, inside), row.set(9, uneven, uneven), row.set(10, surface), row.set(11, 7),
        row.set(12, 0.125, 1);
    expect_kernel<kernels::fluid_gradient_sum::Args>(GetParam(), 128, in, {{"spread_row", row}}, 16);
  }
}

struct Evenness {
  double uneven, nearest;
};
Evenness evenness(const NearCloud& c) {
  const auto list = c.lists();
  Evenness found{0, 1e9};
  for (std::size_t i = 0; i < c.place.size(); ++i) {
    Vector3 g = Vector3::Zero();
    for (const std::uint32_t j : list[i]) {
      g += spiky_gradient(c, c.between(i, j));
      found.nearest = std::min(found.nearest, c.between(i, j).norm() / c.spacing);
    }
    found.uneven += g.squaredNorm() * c.spacing * c.spacing;
  }
  return found;
}

void iterate(Device& device, NearCloud& c, int form, double sign = 1) {
  Values in = values_of(c);
  in["fickian"] = {double(form == 0)}, in["form"] = {double(form)};
  const auto places = static_cast<std::uint32_t>(c.places());
  const auto run = [&]<class Args>(Args, const Values& more) {
    for (const auto& [name, values] : run_kernel<Args>(device, places, chosen<Args>(in, more)))
      in[name] = values;
  };
  run(Gradient{}, {});
  if (form > 0) run(Newton{}, {{"rate", {0.2}}});
  run(Redistribute{}, form == 2 ? Values{{"rate", {sign * 2 / (c.spacing * c.spacing)}}} : Values{});
  for (std::size_t i = 0; i < c.place.size(); ++i) c.place[i] = vector_at(in["fluid_shift"], i);
}

// A block that repeats in all directions, jittered by .2 spacings, as a fluid inside of which nothing pulls.
TEST_P(FluidRedistribute, TenIterationsSmoothAJitteredBlock) {
  const bool is_double = GetParam().precision == Precision::double_precision;
  struct Case {
    const char* name;
    int form;
    double sign;
  };
  for (const Case& each : {Case{"Fickian", 0, 1}, Case{"Newton", 1, 1}, Case{"Eq. 24 as printed", 2, 1},
                           Case{"Eq. 24 with the other sign", 2, -1}}) {
    NearCloud c = jittered_cube(8, 0.2, kernel_seed + 214);
    c.period = Vector3::Constant(8 * c.spacing);
    const Evenness before = evenness(c);
    const Points start = c.place;
    for (int k = 0; k < 10; ++k) iterate(OpenDevices::of(GetParam()), c, each.form, each.sign);
    const Evenness after = evenness(c);
    Vector3 drift = Vector3::Zero();
    for (std::size_t i = 0; i < start.size(); ++i)
      drift += (c.place[i] - start[i]) / static_cast<double>(start.size());
    std::printf("%s: sum of |grad rho|^2 %.3g -> %.3g (over %.1f), least distance %.2f -> %.2f spacings\n",
                each.name, before.uneven, after.uneven, before.uneven / after.uneven, before.nearest,
                after.nearest);
    // Places of 4 spacings rounded ten times, 512 of them.
    if (each.form != 2 || each.sign < 0)
      expect_below("drift of the centre, spacings", drift.norm() / c.spacing, is_double ? 1e-12 : 1e-6);
    if (each.form == 0) {
      expect_above("times by which it fell", before.uneven / after.uneven, 50);
      expect_above("least distance, spacings", after.nearest, 0.6);
    } else if (each.form == 1) {
      expect_above("times by which it fell", before.uneven / after.uneven, 15);
    } else if (each.sign > 0) { // towards the neighbours: the printed sign makes it worse
      expect_above("times by which it rose", after.uneven / before.uneven, 2);
    }
  }
}

TEST(FluidRedistributeThreads, SameBits) {
  const NearCloud start = jittered_cube(11, 0.2, kernel_seed + 215);
  for (const int form : {0, 1}) {
    std::vector<Points> found;
    for (const unsigned threads : {1u, 2u}) {
      const std::unique_ptr<Device> device =
          open_alone({"openmp_float", "openmp", Precision::single_precision}, threads);
      NearCloud c = start;
      iterate(*device, c, form);
      found.push_back(c.place);
    }
    EXPECT_TRUE(found[0] == found[1]);
  }
}

} // namespace
} // namespace pliant::test
