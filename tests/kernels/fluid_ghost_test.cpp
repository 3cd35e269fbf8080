// Ghosts: their cells, and their places in the sorted order.
#include "kernels/fluid_ghost_cell.h"
#include "kernels/fluid_ghost_gather.h"
#include "tests/support/kernel_particles.h"

namespace pliant::test {
namespace {

PLIANT_ON_EVERY_DEVICE(FluidGhost);

TEST_P(FluidGhost, Cells) {
  for (const std::size_t count : awkward_sizes) {
    Random random(kernel_seed + 221);
    const double particles = 5, cells[] = {4, 3, 5};
    Values in{{"particle_count", {particles}},
              {"per_cell_x", {2}},
              {"per_cell_y", {4}},
              {"per_cell_z", {8}},
              {"cells_x", {4}},
              {"cells_y", {3}},
              {"cells_z", {5}}};
    in["ghost_place"] = random_groups(random, count, 3);
    in["cell_of"] = std::vector<double>(count + 10, 77);
    in["cell_count"] = std::vector<double>(61, 1);
    Expected cell(in["cell_of"]), number(in["cell_count"]);
    for (std::size_t i = 0; i < count; ++i) {
      double& mass = in["ghost_place"][4 * i + 3];
      if (i % 6 == 0) mass = 0;
      const auto axis = [&](std::size_t a, double per_cell) {
        const double at = std::floor(in["ghost_place"][4 * i + a] * per_cell);
        return at - cells[a] * std::floor(at / cells[a]);
      };
      const double its = mass == 0 ? 60 : (axis(2, 8) * 3 + axis(1, 4)) * 4 + axis(0, 2);
      cell.set(i + 5, its);
      number.value[static_cast<std::size_t>(its)] += 1;
    }
    expect_kernel<kernels::fluid_ghost_cell::Args>(GetParam(), static_cast<std::uint32_t>(count), in,
                                                   {{"cell_of", cell}, {"cell_count", number}}, 0);
  }
}

TEST_P(FluidGhost, Gather) {
  Random random(kernel_seed + 222);
  const std::size_t particles = 20, ghosts = 9, places = 48;
  Values in{{"particle_count", {double(particles)}}, {"ghost_count", {double(ghosts)}}};
  std::vector<double>& order = in["fluid_particle"];
  for (std::size_t i = 0; i < places; ++i) order.push_back(double((i * 7) % (particles + ghosts)));
  in["ghost_place"] = random_groups(random, ghosts, 2),
  in["ghost_velocity"] = random_groups(random, ghosts, 2);
  in["ghost_place"][4 * 3 + 3] = 0;
  for (const char* name : {"fluid_place", "fluid_velocity", "fluid_start"})
    in[name] = random_groups(random, places, 2);
  Expected place(in["fluid_place"]), velocity(in["fluid_velocity"]), start(in["fluid_start"]);
  for (std::size_t i = 0; i < particles + ghosts; ++i) {
    if (order[i] < double(particles)) continue;
    const std::size_t ghost = static_cast<std::size_t>(order[i]) - particles;
    if (ghost == 3) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      place.set(4 * i + k, in["ghost_place"][4 * ghost + k]);
      velocity.set(4 * i + k, in["ghost_velocity"][4 * ghost + k]);
      start.set(4 * i + k, k < 3 ? in["ghost_place"][4 * ghost + k] : 0);
    }
  }
  expect_kernel<kernels::fluid_ghost_gather::Args>(
      GetParam(), places, in, {{"fluid_place", place}, {"fluid_velocity", velocity}, {"fluid_start", start}},
      0);
}

} // namespace
} // namespace pliant::test
