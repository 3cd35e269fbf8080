// Bonds between neighbours of now: forces against the energy, the return to the yield surface, and the rest
// lengths that follow.
#include "kernels/fluid_bond_begin.h"
#include "kernels/fluid_bond_end.h"
#include "kernels/fluid_bond_flow.h"
#include "kernels/fluid_bond_force.h"
#include "kernels/fluid_bond_hold.h"
#include "kernels/fluid_bond_return.h"
#include "kernels/fluid_bond_state.h"
#include "kernels/fluid_bond_sum.h"
#include "shaders/common/solver.glsl"
#include "tests/support/fluid_bonds.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FluidBondForce);

namespace kernel = kernels;
using Begin = kernel::fluid_bond_begin::Args;
using State = kernel::fluid_bond_state::Args;
using Force = kernel::fluid_bond_force::Args;
using Return = kernel::fluid_bond_return::Args;
using Flow = kernel::fluid_bond_flow::Args;
using Sum = kernel::fluid_bond_sum::Args;

struct Matter {
  double k, ratio, relaxed, volume, shear, pressure, strength, hardening;
};
constexpr Matter matter[] = {{2, 1.5, 0.75, 0x1p-10, 8, 2, 0.375, 0.5}, {4, 0.75, 1, 0x1p-9, 16, 0, 0.5, 0}};
constexpr double equivalent = 2.25;

/// Two materials, some ghosts, and places without bonds; a random displacement from where the step starts.
struct Problem {
  NearCloud cloud;
  Points u;
  std::vector<double> before; // equivalent plastic strain
  RestOf rest;

  explicit Problem(bool periodic) {
    Random random(kernel_seed + 311);
    cloud = jittered_cube(5, 0.15, kernel_seed + 312);
    if (periodic) cloud.period = Vector3::Constant(5 * cloud.spacing);
    for (std::size_t i = 0; i < cloud.place.size(); ++i) {
      if (i % 9 == 4) cloud.mass[i] = -0.25;
      cloud.fourth[i] = double(i % 2);
      u.push_back(cloud.mass[i] < 0 ? Vector3::Zero() : Vector3(random.vector(0.05 * cloud.spacing)));
      for (int a = 0; a < 3; ++a) u.back()[a] = rounded(u.back()[a]);
      before.push_back(rounded(0.1 + random(0.1)));
    }
    rest = [this](std::size_t i, std::size_t j) {
      return bonded(i, j) ? rounded(cloud.between(i, j).norm() * (1 + 0.05 * pair_number(i, j, 4))) : 0;
    };
  }
  bool alone(std::size_t i) const { return i % 13 == 5; } // of matter without bonds
  bool bonded(std::size_t i, std::size_t j) const {
    return cloud.mass[i] > 0 && !alone(i) && (cloud.mass[j] < 0 || !alone(j));
  }
  const Matter& of(std::size_t i) const { return matter[static_cast<std::size_t>(cloud.fourth[i])]; }
  double k(std::size_t i) const { return cloud.mass[i] > 0 && !alone(i) ? of(i).k : 0; }

  Values values() const {
    Values in = bond_values(cloud, rest);
    std::vector<double>& table = in["fluid_elastic"];
    for (const Matter& m : matter)
      table.insert(table.end(),
                   {m.k, m.ratio, m.relaxed, m.volume, m.shear, m.pressure, m.strength, m.hardening});
    table.resize(std::size_t{4} * FLUIDS * ELASTIC_ROWS, 0);
    for (std::size_t i = 0; i < cloud.places(); ++i) {
      const bool there = i < cloud.place.size();
      const Vector3 v = there ? u[i] : Vector3::Zero();
      in["fluid_displacement"].insert(in["fluid_displacement"].end(), {v.x(), v.y(), v.z(), 0});
      in["fluid_stay"].insert(in["fluid_stay"].end(),
                              {there && cloud.mass[i] > 0 ? 1.0 : 0.0, 0, there ? k(i) : 0, there && k(i) > 0 ? cloud.fourth[i] : 0});
      in["fluid_flow"].insert(in["fluid_flow"].end(), {there ? before[i] : 0, 0.5, 0.25, 0, 0, 1, 1, 0});
    }
    in["solver"] = std::vector<double>(SOLVER_ENTRIES, 0.0);
    in["equivalent"] = {equivalent};
    return in;
  }
  Vector3 stretched(std::size_t i, std::size_t j) const { return -cloud.between(i, j) + u[j] - u[i]; }
};

/// Averages over a particle's bonds, and what stays of them.
struct Neighbourhood {
  double weight = 0, isotropic = 0, square = 0;
  double stays_isotropic = 1, stays = 1, strain = 0;
  bool yields = false;
};
Neighbourhood look(const Problem& p, std::size_t i, bool plastic) {
  Neighbourhood n;
  double first = 0, second = 0;
  for (std::size_t j = 0; j < p.cloud.place.size(); ++j) {
    const Vector3 y = p.cloud.between(i, j);
    if (i == j || !(y.norm() < p.cloud.support_in_float()) || !p.bonded(i, j)) continue;
    const double x = p.rest(i, j), e = p.stretched(i, j).norm() / x - 1, w = weight_at(p.cloud, y);
    n.weight += w, first += w * e, second += w * e * e;
  }
  if (!(n.weight > 0)) return n;
  n.isotropic = first / n.weight;
  n.square = second / n.weight - n.isotropic * n.isotropic;
  if (!plastic) return n;
  const Matter& m = p.of(i);
  n.stays = m.relaxed;
  const double rms = m.relaxed * std::sqrt(n.square);
  const double bears = m.strength + m.hardening * p.before[i] - m.pressure * n.isotropic;
  if (m.shear * rms <= bears) return n;
  n.yields = true;
  n.strain = std::min((m.shear * rms - bears) / (m.shear / equivalent + m.hardening), equivalent * rms);
  n.stays = m.relaxed * (1 - n.strain / (equivalent * rms));
  const double apex = m.strength + m.hardening * (p.before[i] + n.strain), pull = m.pressure * n.isotropic;
  if (n.strain >= equivalent * rms && pull > apex) n.stays_isotropic = apex / pull;
  return n;
}

TEST_P(FluidBondForce, StateAndForce) {
  for (const bool periodic : {false, true})
    for (const bool plastic : {false, true}) {
      const Problem p(periodic);
      Values in = p.values();
      in["plastic"] = {double(plastic)};
      const std::size_t n = p.cloud.place.size();
      const auto places = static_cast<std::uint32_t>(p.cloud.places());
      Expected stay(in.at("fluid_stay"));
      std::vector<Neighbourhood> all(n);
      std::size_t yielding = 0;
      for (std::size_t i = 0; i < n; ++i) {
        if (!(p.k(i) > 0)) continue;
        all[i] = look(p, i, plastic);
        yielding += all[i].yields;
        // A rms from squares less the square of the mean: as much wrong as that is smaller. Strains are
        // differences of lengths twenty times as long.
        stay.set(4 * i, all[i].stays, 60);
        stay.set(4 * i + 2, p.k(i) / std::max(all[i].weight, FULL_BONDS), p.k(i));
        stay.set(4 * i + 1, (p.of(i).ratio * all[i].stays_isotropic - all[i].stays) * all[i].isotropic, 6);
      }
      EXPECT_EQ(yielding > 10 && yielding < n - 20, plastic) << yielding;
      in["fluid_stay"] = expect_kernel<State>(GetParam(), places, chosen<State>(in), {{"fluid_stay", stay}},
                                              20)["fluid_stay"];
      for (std::size_t i = 0; i < places; ++i)
        for (std::size_t c = 0; c < 3; ++c)
          in["fluid_stay"][4 * i + c] = rounded(in["fluid_stay"][4 * i + c]);
      in["bound"] = {1.5};
      in["fluid_force"] = guarded(std::vector<double>(std::size_t{4} * places, sentinel), 4);
      Expected force(in["fluid_force"]);
      for (std::size_t i = 0; i < places; ++i) {
        Vector3 f = Vector3::Zero();
        double stiffness = 0, scale = 0;
        const auto part = [&](std::size_t of, double e) {
          const double* s = &in["fluid_stay"][4 * of];
          return s[2] * (s[0] * e + s[1]);
        };
        for (std::size_t j = 0; i < n && j < n && p.k(i) > 0; ++j) {
          const Vector3 from = p.cloud.between(i, j), y = p.stretched(i, j);
          if (i == j || !(from.norm() < p.cloud.support_in_float()) || !p.bonded(i, j)) continue;
          const double x = p.rest(i, j), e = y.norm() / x - 1, w = weight_at(p.cloud, from) / x;
          f += w * (part(i, e) + part(j, e)) * y.normalized();
          stiffness += 1.5 * w / x * (in["fluid_stay"][4 * i + 2] + in["fluid_stay"][4 * j + 2]);
          scale += w * (p.k(i) + p.k(j)); // of strains that are differences of ones
        }
        set_vector(force, i, f, Vector3::Constant(scale));
        const bool ghost = i >= n || p.cloud.mass[i] < 0;
        force.set(4 * i + 3, ghost ? -1 : stiffness, stiffness);
      }
      expect_kernel<Force>(GetParam(), places, chosen<Force>(in), {{"fluid_force", force}}, 12);
      in["solver"][SOLVER_STOP] = 1;
      expect_kernel<Force>(GetParam(), places, chosen<Force>(in),
                           {{"fluid_force", Expected(in["fluid_force"])}}, 0);
    }
}

/// V W summed: of what flows keeping its pressure, the potential of an implicit step (Huber's function of the
/// rms), without friction and hardening.
double potential(const Problem& p, bool plastic) {
  double sum = 0;
  for (std::size_t i = 0; i < p.cloud.place.size(); ++i) {
    if (!(p.k(i) > 0)) continue;
    const Neighbourhood n = look(p, i, false);
    const Matter& m = p.of(i);
    double shear = n.square;
    const double most = m.strength / m.shear, rms = std::sqrt(n.square);
    if (plastic && rms > most) shear = 2 * most * rms - most * most;
    sum += p.k(i) / 2 * n.weight / std::max(n.weight, FULL_BONDS) *
           (shear + m.ratio * n.isotropic * n.isotropic);
  }
  return sum;
}

TEST(FluidBondEnergy, ForcesAreItsSlope) {
  const DeviceChoice choice{"openmp_double", "openmp", Precision::double_precision};
  for (const bool plastic : {false, true}) {
    Problem p(true);
    for (double& fourth : p.cloud.fourth) fourth = 1; // no friction, no hardening, no relaxation
    Values in = p.values();
    in["plastic"] = {double(plastic)};
    in["bound"] = {1};
    in["fluid_force"] = std::vector<double>(4 * p.cloud.places(), sentinel);
    const auto places = static_cast<std::uint32_t>(p.cloud.places());
    Device& device = OpenDevices::of(choice);
    in["fluid_stay"] = run_kernel<State>(device, places, chosen<State>(in))["fluid_stay"];
    const std::vector<double> force = run_kernel<Force>(device, places, chosen<Force>(in))["fluid_force"];
    double worst = 0, size = 0;
    Vector3 sum = Vector3::Zero(), of_ghosts = Vector3::Zero();
    for (std::size_t i = 0; i < p.cloud.place.size(); ++i) {
      const Vector3 f = vector_at(force, i);
      sum += f;
      size = std::max(size, f.norm());
      if (i % 25 != 7 || !(p.k(i) > 0)) continue;
      for (int a = 0; a < 3; ++a) {
        const double step = 1e-6 * p.cloud.spacing, kept = p.u[i][a];
        p.u[i][a] = kept + step;
        const double up = potential(p, plastic);
        p.u[i][a] = kept - step;
        const double down = potential(p, plastic);
        p.u[i][a] = kept;
        worst = std::max(worst, std::abs((down - up) / (2 * step) - f[a]));
      }
    }
    expect_below("force against the slope of the energy, of the largest force", worst / size, 1e-6);
    // Momentum goes to ghosts alone: what bonds to them pull.
    for (std::size_t i = 0; i < p.cloud.place.size(); ++i)
      for (std::size_t g = 0; g < p.cloud.place.size(); ++g) {
        const Vector3 from = p.cloud.between(i, g), y = p.stretched(i, g);
        if (p.cloud.mass[g] > 0 || !(from.norm() < p.cloud.support_in_float()) || !p.bonded(i, g)) continue;
        const double x = p.rest(i, g), e = y.norm() / x - 1, *stay = &in["fluid_stay"][4 * i];
        of_ghosts += weight_at(p.cloud, from) / x * stay[2] * (stay[0] * e + stay[1]) * y.normalized();
      }
    expect_below("momentum, of the largest force", (sum - of_ghosts).norm() / size, 1e-13);
  }
}

TEST_P(FluidBondForce, Begin) {
  const DeviceChoice choice = GetParam();
  Device& device = OpenDevices::of(choice);
  const std::uint32_t places = 16;
  const double h = 0.0625;
  std::vector<Real4<double>> place(places, {1, 2, 3, 0}), velocity(places, {0, 0, 0, 0}), flow(2 * places),
      elastic(std::size_t{FLUIDS} * ELASTIC_ROWS, {0, 0, 0, 0});
  elastic[ELASTIC_ROWS + ELASTIC_BONDS].x = 3;
  std::vector<Uint4> was(places, {0, 0, 0, 0});
  for (std::uint32_t i = 0; i < 6; ++i) {
    place[i].w = i == 2 || i == 5 ? -0.5 : i == 3 ? 0 : 0.5;
    velocity[i] = {double(i), 1, -1, 1};
    was[i] = {5 - i, i == 4 ? 0 : i == 2 ? FAMILY_GHOST : 1, i, 1}; // 5: held by a nozzle
  }
  for (std::uint32_t k = 0; k < 2 * places; ++k) flow[k] = {double(k), 0.5, 0.25, 1};
  const auto make = [&](const char* name, const std::vector<Real4<double>>& values) {
    Buffer buffer = device.allocate(name, Type::real4, values.size());
    device.upload(buffer, values);
    return buffer;
  };
  const Buffer places_of = make("fluid_place", place), speeds = make("fluid_velocity", velocity),
               table = make("fluid_elastic", elastic), earlier = make("fluid_flow_earlier", flow);
  const Buffer was_of = device.allocate("fluid_was", Type::uint4, places);
  device.write(was_of, 0, std::as_bytes(std::span(was)));
  const Buffer target = make("t", place), u = make("u", place), stay = make("s", place),
               now = make("f", flow);
  device.run(Begin{.threads = places,
                   .plastic = 1,
                   .time_step = h,
                   .fluid_elastic = table,
                   .fluid_place = places_of,
                   .fluid_velocity = speeds,
                   .fluid_was = was_of,
                   .fluid_flow_earlier = earlier,
                   .fluid_target = target,
                   .fluid_displacement = u,
                   .fluid_stay = stay,
                   .fluid_flow = now});
  const auto same = [](const Real4<double>& a, const Real4<double>& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w;
  };
  const auto got_target = device.download_real4(target), got_u = device.download_real4(u),
             got_stay = device.download_real4(stay), got_flow = device.download_real4(now);
  for (std::uint32_t i = 0; i < places; ++i) {
    const bool bonds = i < 6 && i != 2 && i != 3 && i != 4, goes = bonds || i == 4, moves = goes && i != 5;
    const Real4<double> away{goes ? h * i : 0, goes ? h : 0, goes ? -h : 0, 0};
    EXPECT_TRUE(same(got_u[i], away)) << i;
    EXPECT_TRUE(same(got_target[i], {away.x, away.y, away.z, moves ? 0.5 / (h * h) : -1})) << i;
    EXPECT_TRUE(same(got_stay[i], {goes ? 1. : 0, 0, bonds ? 3. : 0, bonds ? 1. : 0})) << i;
    EXPECT_TRUE(same(got_flow[2 * i],
                     bonds ? Real4<double>{double(2 * (5 - i)), 0.5, 0.25, 0} : Real4<double>{0, 0, 0, 0}))
        << i;
    EXPECT_TRUE(same(got_flow[2 * i + 1], {0, 1, 1, 0})) << i;
  }
}

TEST_P(FluidBondForce, ReturnAndSum) {
  const Problem p(false);
  Values in = p.values();
  const std::size_t n = p.cloud.place.size();
  const auto places = static_cast<std::uint32_t>(p.cloud.places());
  Problem end = p; // places of the end, exact in float, and what leads there
  end.rest = [&](std::size_t i, std::size_t j) { return p.rest(i, j); };
  for (std::size_t i = 0; i < n; ++i)
    for (int a = 0; a < 3; ++a) {
      double& at = in["fluid_place"][4 * i + static_cast<std::size_t>(a)];
      at = rounded(at + p.u[i][a]);
      end.u[i][a] = at - p.cloud.place[i][a];
    }
  in["plastic"] = {1}, in["measured"] = {1}, in["dimension"] = {3};
  in["fluid_energy"] = guarded(std::vector<double>(places, sentinel), 1);
  Expected flow(in["fluid_flow"]), energy(in["fluid_energy"]);
  double flowing = 0, taken = 0, gained = 0, stored = 0, strains = 0, lost = 0;
  for (std::size_t i = 0; i < places; ++i) {
    energy.set(i, 0);
    if (i >= n || !(p.k(i) > 0)) continue;
    Neighbourhood s = look(end, i, true);
    s.stays_isotropic *= s.stays; // what flows loses its pressure
    const Matter& m = p.of(i);
    const double shear = p.k(i) * s.weight * s.square,
                 volume = p.k(i) * s.weight * m.ratio * s.isotropic * s.isotropic;
    const double work =
        shear * s.stays * (1 - s.stays) + volume * s.stays_isotropic * (1 - s.stays_isotropic);
    // Strains are differences of lengths twenty times as long, in float: squares of .05 wrong by .01 of 1.
    flow.set(8 * i, p.before[i] + s.strain, 10);
    flow.set(8 * i + 1, 0.5 + work, 0.5 + p.k(i) * s.weight);
    flow.set(8 * i + 2, 0.25 + m.volume * 3 * (1 - s.stays_isotropic) * s.isotropic, 1);
    flow.set(8 * i + 3, s.yields);
    flow.set(8 * i + 4, s.isotropic, 2);
    flow.set(8 * i + 5, s.stays_isotropic, 60);
    flow.set(8 * i + 6, s.stays, 60);
    flow.set(8 * i + 7, equivalent * (1 - s.stays) * std::sqrt(s.square), 60);
    energy.set(i, (shear * s.stays * s.stays + volume * s.stays_isotropic * s.stays_isotropic) / 2,
               p.k(i) * s.weight);
  }
  const Values got = expect_kernel<Return>(GetParam(), places, chosen<Return>(in),
                                           {{"fluid_flow", flow}, {"fluid_energy", energy}}, 20);
  Values sums{{"plastic", {1}},
              {"place_count", {double(places)}},
              {"row", {1}},
              {"fluid_flow", got.at("fluid_flow")},
              {"fluid_energy", got.at("fluid_energy")},
              {"bond_row", std::vector<double>(18, sentinel)}};
  for (const char* name : {"fluid_flow", "fluid_energy"})
    for (double& value : sums[name]) value = rounded(value);
  for (std::size_t i = 0; i < places; ++i) {
    const double* f = &sums["fluid_flow"][8 * i];
    flowing += f[3], taken += f[1], gained += f[2], stored += sums["fluid_energy"][i];
    strains = std::max(strains, f[0]), lost = std::max(lost, 1 - std::min(f[5], f[6]));
  }
  Expected row(sums["bond_row"]);
  const double values[] = {flowing, taken, strains, gained, lost, stored},
               scale[] = {0, taken, 0, gained, 1, stored};
  for (std::size_t k = 0; k < 6; ++k) row.set(6 + k, values[k], scale[k]);
  EXPECT_GT(flowing, 10);
  expect_kernel<Sum>(GetParam(), kernel::fluid_bond_sum::group_size, sums, {{"bond_row", row}}, 16);
}

TEST_P(FluidBondForce, WhatDoesNotFlowStays) {
  for (const bool plastic : {false, true})
    for (const std::size_t size : awkward_sizes) {
      Random random(kernel_seed + 314);
      Values in{{"plastic", {double(plastic)}}, {"rate", {0.5}}};
      in["fluid_before"] = random_groups(random, size, 1);
      in["fluid_place"] = guarded(random_groups(random, size, 1), 4);
      Expected place(in["fluid_place"]);
      for (std::size_t i = 0; i < size; ++i) {
        const double flowed = i % 4 == 0 ? 0 : i % 4 == 1 ? 8 : 0.25, most = plastic ? 0.5 * flowed : 0;
        in["fluid_stay"].insert(in["fluid_stay"].end(), {1, 0, i % 5 ? 2. : 0, 0});
        if (plastic) in["fluid_flow"].insert(in["fluid_flow"].end(), {0, 0, 0, 0, 0, 1, 0.5, flowed});
        const Vector3 before = vector_at(in["fluid_before"], i), now = vector_at(in["fluid_place"], i);
        if (i % 5 == 0 || (now - before).norm() <= most) continue;
        set_vector(place, i, before + most * (now - before).normalized(), before.cwiseAbs() + now.cwiseAbs());
      }
      expect_kernel<kernel::fluid_bond_hold::Args>(GetParam(), static_cast<std::uint32_t>(size), in,
                                                   {{"fluid_place", place}}, 4);
    }
}

TEST_P(FluidBondForce, EndsInPlacesAndVelocities) {
  for (const std::size_t size : awkward_sizes) {
    Random random(kernel_seed + 315);
    Values in{{"time_step", {0.0625}}};
    in["fluid_start"] = random_groups(random, size, 1);
    in["fluid_best"] = random_groups(random, size, 0.01);
    in["fluid_velocity"] = guarded(random_groups(random, size, 1), 4);
    in["fluid_place"] = guarded(random_groups(random, size, 1), 4);
    Expected place(in["fluid_place"]), velocity(in["fluid_velocity"]);
    for (std::size_t i = 0; i < size; ++i) {
      in["fluid_place"][4 * i + 3] = place.value[4 * i + 3] = i % 3 == 0 ? -1 : 0.5;
      if (i % 3 == 0) continue;
      const Vector3 start = vector_at(in["fluid_start"], i), u = vector_at(in["fluid_best"], i);
      set_vector(place, i, start + u, start.cwiseAbs() + u.cwiseAbs());
      set_vector(velocity, i, 16 * u, Vector3::Zero());
    }
    expect_kernel<kernel::fluid_bond_end::Args>(GetParam(), static_cast<std::uint32_t>(size), in,
                                                {{"fluid_place", place}, {"fluid_velocity", velocity}}, 2);
  }
}

TEST_P(FluidBondForce, RestLengthsFlowAlikeAtBothEnds) {
  for (const bool spread : {false, true})
    for (const bool plastic : {false, true}) {
      if (!spread && !plastic) continue;
      Problem p(true);
      Random random(kernel_seed + 313);
      Values in = p.values();
      const std::size_t n = p.cloud.place.size();
      const auto places = static_cast<std::uint32_t>(p.cloud.places());
      in["plastic"] = {double(plastic)}, in["spread"] = {double(spread)};
      in["least_rest"] = {0x1p-14}, in["largest_rest"] = {1};
      for (std::size_t i = 7; i < n; i += 9) // held by a nozzle, which is no ghost
        in["fluid_place"][4 * i + 3] = -std::abs(in["fluid_place"][4 * i + 3]);
      in["fluid_before"] = in["fluid_place"];
      Points moved(n, Vector3::Zero());
      for (std::size_t i = 0; i < n; ++i) {
        double* const flow = &in["fluid_flow"][8 * i];
        flow[4] = rounded(random(0.05)), flow[5] = 1, flow[6] = i % 3 ? rounded(0.75 + random(0.2)) : 1;
        if (p.cloud.mass[i] < 0) flow[4] = flow[5] = flow[6] = not_a_number; // ghosts have none
        for (int a = 0; a < 3; ++a) {
          double& at = in["fluid_place"][4 * i + static_cast<std::size_t>(a)];
          const double was = at;
          if (p.cloud.mass[i] > 0) at = rounded(at + 0.02 * random() * p.cloud.spacing);
          moved[i][a] = at - was;
        }
      }
      Expected rest(in["near_rest"]);
      for_each_entry(p.cloud, in, [&](std::size_t i, std::size_t j, std::size_t entry) {
        const double x = in["near_rest"][entry];
        if (!(x > 0)) return;
        const double size = p.cloud.between(i, j).norm(), e = size / x - 1;
        const auto stays = [&](std::size_t of) {
          const double* f = &in["fluid_flow"][8 * of + 4];
          return f[1] * f[0] + f[2] * (e - f[0]);
        };
        double wanted = x;
        const auto flows = [&](std::size_t of) { return in["fluid_flow"][8 * of + 6] < 1; };
        const std::size_t other = p.cloud.mass[j] < 0 ? i : j;
        if (plastic && (flows(i) || flows(other))) wanted = size / (1 + (stays(i) + stays(other)) / 2);
        if (spread) wanted *= (p.cloud.between(i, j) + moved[i] - moved[j]).norm() / size;
        rest.set(entry, wanted, plastic || spread ? wanted : 0);
      });
      const Values got = expect_kernel<Flow>(GetParam(), places, chosen<Flow>(in), {{"near_rest", rest}}, 12);
      std::map<std::pair<std::size_t, std::size_t>, double> ends;
      for_each_entry(p.cloud, in, [&](std::size_t i, std::size_t j, std::size_t entry) {
        if (p.cloud.mass[i] < 0 || p.cloud.mass[j] < 0) return;
        const double value = got.at("near_rest")[entry];
        const auto [end, first] = ends.emplace(std::pair{std::min(i, j), std::max(i, j)}, value);
        EXPECT_EQ(end->second, value) << "the ends of a bond differ";
      });
    }
}

} // namespace
} // namespace pliant::test
