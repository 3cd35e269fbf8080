// Bonds between neighbours of now: rest lengths carried over, and those of new neighbours (Eq. 20 of He, Wang
// and Wu 2017, in lengths).
#include "kernels/fluid_bond_carry.h"
#include "kernels/fluid_bond_fit.h"
#include "kernels/fluid_bond_rest.h"
#include "kernels/fluid_bond_was.h"
#include "tests/support/fluid_bonds.h"

#include <numeric>

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FluidBond);

namespace kernel = kernels;
using Was = kernel::fluid_bond_was::Args;
using Carry = kernel::fluid_bond_carry::Args;
using Fit = kernel::fluid_bond_fit::Args;
using Rest = kernel::fluid_bond_rest::Args;

TEST_P(FluidBond, WhoWasWhere) {
  Device& device = OpenDevices::of(GetParam());
  const std::vector<std::uint32_t> particle{3, 0, 5, 1, 2, 4}, then{7, 9, 2, 4, 1, 12};
  const std::vector<std::uint32_t> kind{0, 4, 1u << FLUID_KIND_SHIFT | 2,
                                        3}; // the second material is a fluid
  std::vector<Real4<double>> elastic(std::size_t{FLUIDS} * ELASTIC_ROWS, {0, 0, 0, 0});
  elastic[ELASTIC_BONDS].x = 2;
  const auto uploaded = [&](const char* name, const std::vector<std::uint32_t>& values) {
    Buffer buffer = device.allocate(name, Type::uint, values.size());
    device.upload(buffer, values);
    return buffer;
  };
  const Buffer particles = uploaded("fluid_particle", particle), kinds = uploaded("fluid_kind", kind),
               places = uploaded("near_place_of", then);
  const Buffer table = device.allocate("fluid_elastic", Type::real4, elastic.size());
  device.upload(table, elastic);
  const Buffer was = device.allocate("fluid_was", Type::uint4, 16);
  device.run(Was{.threads = 16,
                 .particle_count = 4,
                 .ghost_count = 2,
                 .fluid_elastic = table,
                 .fluid_particle = particles,
                 .fluid_kind = kinds,
                 .near_place_of = places,
                 .fluid_was = was});
  std::vector<Uint4> got(16);
  device.read(was, 0, std::as_writable_bytes(std::span(got)));
  for (std::uint32_t k = 0; k < 16; ++k) {
    const bool there = k < 6;
    const std::uint32_t i = there ? particle[k] : 0;
    const std::uint32_t family = !there ? 0 : i >= 4 ? FAMILY_GHOST : i == 2 ? 0 : kind[i] + 1;
    EXPECT_EQ(got[k].x, there ? then[i] : 0) << k;
    EXPECT_EQ(got[k].y, family) << k;
    EXPECT_EQ(got[k].z, i) << k;
    EXPECT_EQ(got[k].w, there ? 1u : 0u) << k;
  }
}

/// A cloud whose places are shuffled particles of two families and some ghosts.
struct Shuffled {
  NearCloud cloud;
  std::vector<std::uint32_t> particle, place_of; // of each place; of each particle

  Shuffled(const Points& at, unsigned seed) : particle(at.size()), place_of(at.size()) {
    std::iota(particle.begin(), particle.end(), 0u);
    std::mt19937 random(seed);
    for (std::size_t k = at.size(); k-- > 1;) std::swap(particle[k], particle[random() % (k + 1)]);
    for (std::uint32_t k = 0; k < particle.size(); ++k) {
      place_of[particle[k]] = k;
      cloud.add(at[particle[k]], 1, 0, Vector3::Zero());
    }
  }
};
std::uint32_t family_of(std::size_t particle) {
  return particle % 7 == 0    ? FAMILY_GHOST
         : particle % 11 == 0 ? 0
                              : 1 + static_cast<std::uint32_t>(particle % 2);
}
bool bonded(std::size_t i, std::size_t j) {
  const std::uint32_t own = family_of(i), other = family_of(j);
  return own != 0 && own != FAMILY_GHOST && (other == own || other == FAMILY_GHOST);
}

TEST_P(FluidBond, RestLengthsGoOnBitForBit) {
  Device& device = OpenDevices::of(GetParam());
  Random random(kernel_seed + 301);
  Points before, after;
  const double d = NearCloud().spacing;
  for (const Vector3& p : lattice(5, 5, 5, d)) {
    before.push_back(p + random.vector(0.2 * d));
    after.push_back(before.back() + random.vector(0.15 * d));
  }
  const Shuffled then(before, 5), now(after, 6);
  const auto length = [](std::size_t i, std::size_t j) { return rounded(1.5 + pair_number(i, j, 9)); };
  Values old = bond_values(then.cloud, [&](std::size_t a, std::size_t b) {
    return bonded(then.particle[a], then.particle[b]) ? length(then.particle[a], then.particle[b]) : 0;
  });
  Values in = bond_values(now.cloud, [](std::size_t, std::size_t) { return 0.0; });
  // Both have room for the longer lists.
  const auto rows = static_cast<std::size_t>(std::max(old["rows"][0], in["rows"][0]));
  const auto widened = [&](const Values& from, const char* name) {
    const auto own = static_cast<std::size_t>(from.at("rows")[0]), slices = from.at("near_count").size();
    std::vector<double> wide(16 * rows * slices, 0.0);
    for (std::size_t s = 0; s < slices; ++s)
      std::copy_n(from.at(name).begin() + static_cast<std::ptrdiff_t>(16 * own * s), 16 * own,
                  wide.begin() + static_cast<std::ptrdiff_t>(16 * rows * s));
    return wide;
  };
  Values given{{"rows", {double(rows)}},
               {"near_count", in["near_count"]},
               {"near", widened(in, "near")},
               {"near_count_earlier", old["near_count"]},
               {"near_earlier", widened(old, "near")},
               {"near_rest_earlier", widened(old, "near_rest")}};
  const auto places = static_cast<std::uint32_t>(now.cloud.places());
  std::vector<Uint4> was(places, {0, 0, 0, 0});
  for (std::uint32_t k = 0; k < now.particle.size(); ++k)
    was[k] = {then.place_of[now.particle[k]], family_of(now.particle[k]), now.particle[k], 1};
  std::map<std::string, Buffer> buffers;
  for (const char* name : {"near_count", "near", "near_count_earlier", "near_earlier"}) {
    const std::vector<std::uint32_t> whole(given[name].begin(), given[name].end());
    device.upload(buffers[name] = device.allocate(name, Type::uint, whole.size()), whole);
  }
  device.upload(buffers["near_rest_earlier"] =
                    device.allocate("r", Type::real, given["near_rest_earlier"].size()),
                given["near_rest_earlier"]);
  buffers["fluid_was"] = device.allocate("fluid_was", Type::uint4, places);
  device.write(buffers["fluid_was"], 0, std::as_bytes(std::span(was)));
  buffers["near_rest"] = device.allocate("near_rest", Type::real, given["near"].size());
  buffers["near_place_of"] = device.allocate("near_place_of", Type::uint, now.particle.size());
  device.run(Carry{.threads = places,
                   .rows = static_cast<std::uint32_t>(rows),
                   .near_count = buffers["near_count"],
                   .near = buffers["near"],
                   .near_count_earlier = buffers["near_count_earlier"],
                   .near_earlier = buffers["near_earlier"],
                   .near_rest_earlier = buffers["near_rest_earlier"],
                   .fluid_was = buffers["fluid_was"],
                   .near_rest = buffers["near_rest"],
                   .near_place_of = buffers["near_place_of"]});
  const std::vector<double> rest = device.download_real(buffers["near_rest"]);
  EXPECT_EQ(device.download_uint(buffers["near_place_of"]), now.place_of);
  std::size_t kept = 0, fresh = 0, none = 0;
  const auto list = now.cloud.lists();
  const auto lists_then = then.cloud.lists();
  for (std::size_t a = 0; a < list.size(); ++a)
    for (std::size_t r = 0; r < list[a].size(); ++r) {
      const std::size_t i = now.particle[a], j = now.particle[list[a][r]];
      const auto& earlier = lists_then[then.place_of[i]];
      const bool was_near = std::find(earlier.begin(), earlier.end(), then.place_of[j]) != earlier.end();
      const double wanted = !bonded(i, j) ? 0 : was_near ? length(i, j) : BOND_NEW;
      EXPECT_EQ(rest[16 * (rows * (a / 16) + r) + a % 16], wanted) << i << ", " << j;
      ++(wanted == 0 ? none : wanted > 0 ? kept : fresh);
    }
  EXPECT_GT(kept, 500u);
  EXPECT_GT(fresh, 30u);
  EXPECT_GT(none, 100u);
}

struct Fitted {
  Values in;
  std::vector<double> fit, rest;
};
/// Fits, and gives the new bonds their lengths.
Fitted rest_lengths(const DeviceChoice& choice, const NearCloud& cloud, const RestOf& rest) {
  Fitted found{bond_values(cloud, rest), {}, {}};
  const auto places = static_cast<std::uint32_t>(cloud.places());
  Values in = found.in;
  in["excess"] = {rounded(2 * std::sqrt(cloud.dimension == 2 ? 2. : 5.))};
  in["least_rest"] = {rounded(1e-3 * cloud.spacing)};
  for (std::size_t i = 0; i < places; ++i)
    in["fluid_fit"].insert(in["fluid_fit"].end(), {1, 1, 1, 0, 0, 0, 1, 1});
  Device& device = OpenDevices::of(choice);
  found.fit = run_kernel<Fit>(device, places, chosen<Fit>(in))["fluid_fit"];
  in["fluid_fit"] = found.fit;
  found.rest = run_kernel<Rest>(device, places, chosen<Rest>(in))["near_rest"];
  return found;
}

Matrix3 sheared() {
  Matrix3 f;
  f << 1.2, 0.15, -0.1, 0.05, 0.85, 0.2, 0, -0.1, 1.05;
  return f;
}

// Any affine state is found again exactly: with a third of the bonds unknown, on a jittered block.
TEST_P(FluidBond, AffineStatesAreFoundAgain) {
  for (const bool flat : {false, true}) {
    NearCloud cloud;
    if (flat) {
      Random random(kernel_seed + 302);
      cloud.dimension = 2;
      for (const Vector3& p : lattice(9, 9, 1, cloud.spacing)) {
        const Vector3 off = random.vector(0.15 * cloud.spacing);
        cloud.add(p + Vector3(off.x(), off.y(), 0), 0.25, 0, Vector3::Zero());
      }
    } else {
      cloud = jittered_cube(6, 0.15, kernel_seed + 303);
    }
    Matrix3 f = sheared();
    if (flat) f.row(2) = f.col(2).transpose() = Vector3(0, 0, 1), f.col(2) = Vector3(0, 0, 1);
    const Matrix3 inverse = f.inverse();
    const auto length = [&](std::size_t i, std::size_t j) { return (inverse * cloud.between(i, j)).norm(); };
    const auto fresh = [](std::size_t i, std::size_t j) { return (i + j) % 3 == 0; };
    const Fitted found = rest_lengths(GetParam(), cloud, [&](std::size_t i, std::size_t j) {
      return fresh(i, j) ? BOND_NEW : length(i, j);
    });
    const auto list = cloud.lists();
    std::vector<std::size_t> known(list.size(), 0);
    for (std::size_t i = 0; i < list.size(); ++i)
      for (const std::uint32_t j : list[i]) known[i] += !fresh(i, j);
    const std::size_t enough = flat ? 6 : 14; // of corners a tensor cannot be told
    double worst = 0;
    std::size_t told = 0;
    const bool wide = GetParam().precision == Precision::double_precision;
    std::map<std::pair<std::size_t, std::size_t>, double> ends;
    for_each_entry(cloud, found.in, [&](std::size_t i, std::size_t j, std::size_t entry) {
      if (!fresh(i, j)) {
        const double given = found.in.at("near_rest")[entry];
        EXPECT_EQ(found.rest[entry], wide ? given : rounded(given)) << "a known length changed";
        return;
      }
      const auto [end, first] = ends.emplace(std::pair{std::min(i, j), std::max(i, j)}, found.rest[entry]);
      EXPECT_EQ(end->second, found.rest[entry]) << "the ends of a bond differ";
      if (known[i] < enough || known[j] < enough) return;
      ++told;
      worst = std::max(worst, std::abs(found.rest[entry] / length(i, j) - 1));
    });
    EXPECT_GT(told, flat ? 100u : 500u);
    expect_below(GetParam().name + (flat ? ", flat" : ", block") + ": lengths of new bonds, relative", worst,
                 wide ? 1e-9 : 3e-5);
  }
}

// What no affine state explains is kept within the bounds of what the neighbourhood bears.
TEST_P(FluidBond, ScatteredStatesAreBounded) {
  const NearCloud cloud = jittered_cube(6, 0.2, kernel_seed + 304);
  const auto fresh = [](std::size_t i, std::size_t j) { return (i + j) % 5 == 0; };
  const RestOf rest = [&](std::size_t i, std::size_t j) {
    return fresh(i, j) ? BOND_NEW : rounded(cloud.between(i, j).norm() * (1 + 0.1 * pair_number(i, j, 3)));
  };
  const Fitted found = rest_lengths(GetParam(), cloud, rest);
  const auto list = cloud.lists();
  std::vector<std::array<double, 2>> bounds;
  for (std::size_t i = 0; i < list.size(); ++i) {
    double sum = 0, first = 0, second = 0;
    for (const std::uint32_t j : list[i]) {
      if (fresh(i, j)) continue;
      const Vector3 y = cloud.between(i, j);
      const double w = weight_at(cloud, y), e = y.norm() / rest(i, j) - 1;
      sum += w, first += w * e, second += w * e * e;
    }
    const double mean = first / sum, rms = std::sqrt(second / sum - mean * mean);
    bounds.push_back({1 + mean - 2 * std::sqrt(5.) * rms, 1 + mean + 2 * std::sqrt(5.) * rms});
  }
  for_each_entry(cloud, found.in, [&](std::size_t i, std::size_t j, std::size_t entry) {
    if (!fresh(i, j)) return;
    const double ratio = cloud.between(i, j).norm() / found.rest[entry];
    EXPECT_GE(ratio, std::min(bounds[i][0], bounds[j][0]) - 1e-4);
    EXPECT_LE(ratio, std::max(bounds[i][1], bounds[j][1]) + 1e-4);
  });
}

// Neighbourhoods that know of a plane, a line, one bond or nothing: across, the isotropic part is all there
// is.
TEST_P(FluidBond, ThinAndLonelyNeighbourhoodsStayFinite) {
  const double d = NearCloud().spacing;
  for (const int kind : {0, 1, 2, 3}) {
    NearCloud cloud;
    const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    for (const Vector3& p : lattice(kind < 2 ? 5 : kind == 2 ? 2 : 1, kind == 0 ? 5 : 1, 1, d))
      cloud.add(turn * p, 1, 0, Vector3::Zero());
    const auto known = static_cast<std::uint32_t>(cloud.place.size());
    cloud.add(turn * Vector3(0.5 * d, 0, d), 1, 0, Vector3::Zero()); // a new one, off it
    const double stretch = 1.1;
    const Fitted found = rest_lengths(GetParam(), cloud, [&](std::size_t i, std::size_t j) {
      return i == known || j == known ? BOND_NEW : cloud.between(i, j).norm() / stretch;
    });
    for_each_entry(cloud, found.in, [&](std::size_t i, std::size_t j, std::size_t entry) {
      if (i != known && j != known) return;
      const double ratio = cloud.between(i, j).norm() / found.rest[entry];
      // The new one knows nothing: unstretched. The others know of one stretch, whatever the direction.
      const double wanted = kind == 3 ? 1 : 1 / std::sqrt((1 + 1 / (stretch * stretch)) / 2);
      EXPECT_NEAR(ratio, wanted, GetParam().precision == Precision::double_precision ? 1e-6 : 1e-4) << kind;
    });
  }
}

TEST_P(FluidBond, OfGhostsOnlyThePartnerKnows) {
  NearCloud cloud = jittered_cube(4, 0.1, kernel_seed + 305);
  for (std::size_t i = 0; i < cloud.mass.size(); i += 5) cloud.mass[i] = -0.25;
  const Fitted found = rest_lengths(GetParam(), cloud, [&](std::size_t i, std::size_t j) {
    if (cloud.mass[i] < 0) return 0.0; // a ghost has no bonds of its own
    return cloud.mass[j] < 0 && (i + j) % 2 == 0 ? BOND_NEW : cloud.between(i, j).norm() / 1.1;
  });
  double worst = 0;
  for_each_entry(cloud, found.in, [&](std::size_t i, std::size_t j, std::size_t entry) {
    if (found.in.at("near_rest")[entry] < 0)
      worst = std::max(worst, std::abs(found.rest[entry] / cloud.between(i, j).norm() * 1.1 - 1));
  });
  expect_below(GetParam().name + ": bonds to ghosts, relative", worst,
               GetParam().precision == Precision::double_precision ? 1e-6 : 1e-5);
}

} // namespace
} // namespace pliant::test
