// Runs the kernels of broken bonds; see failure.h.
#include "engine/solver/failure.h"

#include "engine/model/failure.h"
#include "engine/solver/elasticity.h"
#include "engine/solver/state.h"
#include "kernels/bond_break.h"
#include "kernels/bond_release.h"
#include "kernels/fracture_sum.h"
#include "shaders/common/solver.glsl"

#include <algorithm>
#include <cmath>

namespace pliant {

namespace {

constexpr double unbreakable = 1e30; ///< of a squared stretch; a float holds it times a squared length

} // namespace

Failure::Failure(Device& device, const Scene& scene, const Model& model, const Plan& plan,
                 SimulationState& state, Elasticity& elasticity)
    : device_(device), model_(model), plan_(plan), state_(state), elasticity_(elasticity) {
  const std::vector<double> stretch = critical_stretches(scene, model);
  // K_i of the bonds that are left, with the stiffest direction's factor for all of a material's.
  std::vector<double> bound(model.constants.size(), 0);
  for (std::size_t i = 0; i < model.count(); ++i)
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b)
      bound[model.material[i]] = std::max(bound[model.material[i]], bond_bound(model, i, b));
  std::vector<Real4<double>> toughness(model.count());
  for (std::size_t i = 0; i < toughness.size(); ++i)
    toughness[i] = {std::isfinite(stretch[i]) ? (1 + stretch[i]) * (1 + stretch[i]) : unbreakable,
                    bound[model.material[i]], 0, 0};
  device_.upload(state_.toughness, toughness);
  device_.upload(state_.shape, std::vector<double>(model.count(), 1.0), plan_.share_row * model.count());
}

// To where the step ended, by the bonds that are there: the energies before and after breaking then differ by
// nothing but bonds. With statistics or without, so that these change no bit.
void Failure::turn_rotations() {
  if (!plan_.find("rotation")) return;
  device_.upload(state_.solver, std::vector<double>{0}, SOLVER_STOP);
  elasticity_.state(state_.best_iterate);
}

void Failure::break_bonds() {
  SimulationState& s = state_;
  turn_rotations();
  if (plan_.energy) {
    elasticity_.energy(s.best_iterate);
    device_.enter("failure");
    device_.copy(s.energy, s.energy_before);
  }
  device_.enter("failure");
  for (const LawRange& range : model_.laws)
    device_.run(kernels::bond_break::Args{.threads = range.count,
                                          .first = range.first,
                                          .first_slice = range.first_slice,
                                          .stride = static_cast<std::uint32_t>(model_.count()),
                                          .share_row = plan_.share_row,
                                          .unit = elasticity_.unit(),
                                          .slice_begin = s.slice_begin,
                                          .bond = s.bond,
                                          .weight = s.weight,
                                          .position = s.position,
                                          .displacement = s.best_iterate,
                                          .toughness = s.toughness,
                                          .shape = s.shape,
                                          .linear_start = s.linear_start});
  if (!plan_.find("rotation")) return;
  elasticity_.begin();
  turn_rotations();
}

void Failure::release() {
  if (!plan_.energy) return;
  device_.enter("failure");
  device_.run(kernels::bond_release::Args{.threads = static_cast<std::uint32_t>(model_.count()),
                                          .before = state_.energy_before,
                                          .energy = state_.energy,
                                          .released = state_.released});
}

std::unique_ptr<Readback> Failure::sums(std::uint32_t row) {
  if (!plan_.energy) return nullptr;
  device_.enter("failure");
  const auto n = static_cast<std::uint32_t>(model_.count());
  device_.run(kernels::fracture_sum::Args{.threads = kernels::fracture_sum::group_size,
                                          .particle_count = n,
                                          .broken_at = (plan_.share_row + 1) * n,
                                          .row = row,
                                          .shape = state_.shape,
                                          .released = state_.released,
                                          .fracture = state_.fracture});
  const std::size_t bytes = 2 * element_bytes(Type::real, device_.info().precision);
  return device_.request(state_.fracture, row * bytes, bytes);
}

void Failure::repack() {
  SimulationState& s = state_;
  const std::vector<std::uint32_t> begin = device_.download_uint(s.slice_begin);
  std::vector<std::uint32_t> bond = device_.download_uint(s.bond);
  // Arrays of numbers beside the bonds; more where stiffness depends on direction, and where bonds flow.
  std::vector<Buffer*> beside{&s.weight};
  if (plan_.find("strength")) beside.push_back(&s.strength);
  if (plan_.find("rest")) beside.push_back(&s.rest);
  std::vector<std::vector<std::byte>> values;
  for (Buffer* buffer : beside) {
    values.emplace_back((*buffer)->bytes());
    device_.read(*buffer, 0, values.back());
  }
  const std::size_t real = element_bytes(Type::real, device_.info().precision);
  std::vector<std::uint32_t> packed_begin{0};
  for (const LawRange& range : model_.laws)
    for (std::uint32_t from = 0; from < range.count; from += slice_width) {
      const std::size_t slice = range.first_slice + from / slice_width;
      const std::uint32_t target = packed_begin.back(); // never beyond begin[slice]: moved in place
      std::uint32_t most = 0;
      const std::uint32_t rows = begin[slice + 1] - begin[slice];
      for (std::uint32_t lane = 0; lane < slice_width; ++lane) {
        const std::uint32_t self = std::min(range.first + from + lane, range.first + range.count - 1);
        std::uint32_t used = 0;
        const auto move = [&](std::size_t to, std::size_t at) {
          bond[to] = bond[at], bond[to + slice_width] = bond[at + slice_width];
          for (std::vector<std::byte>& value : values)
            for (const std::size_t half : {std::size_t{0}, std::size_t{slice_width}})
              std::copy_n(value.begin() + static_cast<std::ptrdiff_t>((at + half) * real), real,
                          value.begin() + static_cast<std::ptrdiff_t>((to + half) * real));
        };
        for (std::uint32_t row = 0; row < rows; ++row) {
          const std::size_t at = std::size_t{2} * slice_width * (begin[slice] + row) + lane;
          if (bond[at] == self) continue;
          move(std::size_t{2} * slice_width * (target + used++) + lane, at);
        }
        most = std::max(most, used);
        for (std::uint32_t row = used; row < rows; ++row) { // padding again
          const std::size_t at = std::size_t{2} * slice_width * (target + row) + lane;
          bond[at] = self, bond[at + slice_width] = 0;
          for (const std::size_t half : {std::size_t{0}, std::size_t{slice_width}})
            std::fill_n(values[0].begin() + static_cast<std::ptrdiff_t>((at + half) * real), real,
                        std::byte{0});
        }
      }
      packed_begin.push_back(target + most);
    }
  if (packed_begin == begin) return;
  device_.upload(s.slice_begin, packed_begin);
  device_.upload(s.bond, bond);
  for (std::size_t b = 0; b < beside.size(); ++b) device_.write(*beside[b], 0, values[b]);
}

std::vector<double> Failure::damage() {
  const std::size_t n = model_.count();
  std::vector<double> damage = device_.download_real(state_.shape, plan_.share_row * n, n);
  for (double& share : damage) share = 1 - share;
  return damage;
}

} // namespace pliant
