// Law M3 (Xu et al. 2018): energies over basis functions of the dilatation and of each bond's stretch.
#include "engine/core/error.h"
#include "engine/plan/method.h"
#include "engine/solver/elastic_law.h"
#include "engine/solver/state.h"
#include "kernels/stretch_energy.h"
#include "kernels/stretch_force.h"
#include "kernels/stretch_product.h"
#include "kernels/stretch_product_force.h"
#include "kernels/stretch_state.h"
#include "kernels/stretch_tangent.h"
#include "shaders/common/stretch.glsl"

#include <fmt/core.h>

#include <algorithm>

namespace pliant {

namespace {

static_assert(STRETCH_POWERS == largest_powers && STRETCH_LEAST == smallest_stretch &&
              STRETCH_MOST == largest_stretch && STRETCH_BOND == STRETCH_VOLUME + STRETCH_POWERS &&
              STRETCH_ROWS == STRETCH_BOND + STRETCH_POWERS);
constexpr std::size_t table_rows = std::size_t{STRETCH_MATERIALS} * STRETCH_ROWS;

using Rows = std::vector<Real4<double>>;

/// One row for each power n that occurs.
void put_sum(Rows& rows, std::size_t at, const BasisSum& sum) {
  std::size_t used = 0;
  for (const BasisTerm& term : sum.terms) {
    if (term.share == 0) continue;
    std::size_t k = 0;
    while (k < used && rows[at + k].x != term.n) ++k;
    if (k == STRETCH_POWERS)
      throw Error(ExitCode::internal,
                  "a sum of basis functions has more powers than the table of kernels holds");
    if (k == used) rows[at + used++].x = term.n;
    double& share = term.kind == BasisTerm::Kind::A   ? rows[at + k].y
                    : term.kind == BasisTerm::Kind::B ? rows[at + k].z
                                                      : rows[at + k].w;
    share += term.share;
  }
}

/// First row in the table of each material that has this law.
std::vector<std::uint32_t> places(const Model& model) {
  std::vector<std::uint32_t> place(model.stretch.size(), 0);
  std::uint32_t next = 0;
  for (std::size_t m = 0; m < place.size(); ++m)
    if (!model.stretch[m].bond.terms.empty()) place[m] = STRETCH_ROWS * next++;
  if (next > STRETCH_MATERIALS)
    throw Error(ExitCode::usage, fmt::format("{} materials have laws over basis functions; kernels hold {}",
                                             next, STRETCH_MATERIALS));
  return place;
}

bool anisotropic(const Model& model) {
  return !model.bonds.strength.empty();
}

class Basis : public ElasticLaw {
public:
  explicit Basis(const LawContext& context)
      : ElasticLaw(context), anisotropic_(anisotropic(context.model)),
        potential_(choose_method(context.scene, context.model).potential) {}

  void upload(const LawRange& range) override {
    const Model& model = context_.model;
    const std::vector<std::uint32_t> place = places(model);
    Rows rows(table_rows, Real4<double>{0, 0, 0, 0});
    for (std::size_t m = 0; m < place.size(); ++m) {
      const StretchEnergy& energy = model.stretch[m];
      if (energy.bond.terms.empty()) continue;
      rows[place[m]].x = energy.squared;
      put_sum(rows, place[m] + STRETCH_VOLUME, energy.volume);
      put_sum(rows, place[m] + STRETCH_BOND, energy.bond);
    }
    context_.device.upload(context_.state.energies, rows);
    // Row 2 of `shape`: where the particle's material begins in the table, and a half where its whole
    // neighbourhood is of that material, so that a backend may work many bonds off alike.
    std::vector<double> first(range.count);
    for (std::uint32_t local = 0; local < range.count; ++local)
      first[local] = place[model.material[range.first + local]] + (alike(range.first + local) ? 0.5 : 0);
    context_.device.upload(context_.state.shape, first, std::size_t{2} * context_.particles + range.first);
    if (anisotropic_) upload_strengths();
  }
  void state(const LawRange& range, BufferStorage* displacement) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::stretch_state::Args{.threads = range.count,
                                                     .potential = potential_,
                                                     .first = range.first,
                                                     .first_slice = range.first_slice,
                                                     .stride = context_.particles,
                                                     .unit = context_.unit,
                                                     .energies = s.energies,
                                                     .gate = s.solver,
                                                     .slice_begin = s.slice_begin,
                                                     .bond = s.bond,
                                                     .weight = s.weight,
                                                     .position = s.position,
                                                     .displacement = displacement,
                                                     .shape = s.shape,
                                                     .stretch_record = s.stretch_record,
                                                     .energy = summed()});
  }
  void force(const LawRange& range) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::stretch_force::Args{.threads = range.count,
                                                     .anisotropic = anisotropic_,
                                                     .potential = potential_,
                                                     .first = range.first,
                                                     .first_slice = range.first_slice,
                                                     .unit = context_.unit,
                                                     .energies = s.energies,
                                                     .gate = s.solver,
                                                     .slice_begin = s.slice_begin,
                                                     .bond = s.bond,
                                                     .weight = s.weight,
                                                     .stretch_record = s.stretch_record,
                                                     .linear_start = s.linear_start,
                                                     .force = s.force,
                                                     .energy = summed(),
                                                     .strength = s.strength});
  }
  void energy(const LawRange& range, BufferStorage* displacement, bool gated) override {
    if (gated) return; // summed()
    const SimulationState& s = context_.state;
    context_.device.run(kernels::stretch_energy::Args{.threads = range.count,
                                                      .anisotropic = anisotropic_,
                                                      .first = range.first,
                                                      .first_slice = range.first_slice,
                                                      .stride = context_.particles,
                                                      .unit = context_.unit,
                                                      .energies = s.energies,
                                                      .slice_begin = s.slice_begin,
                                                      .bond = s.bond,
                                                      .weight = s.weight,
                                                      .position = s.position,
                                                      .displacement = displacement,
                                                      .shape = s.shape,
                                                      .energy = s.energy,
                                                      .strength = s.strength});
  }
  void tangent(const LawRange& range, BufferStorage* displacement) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::stretch_tangent::Args{.threads = range.count,
                                                       .first = range.first,
                                                       .first_slice = range.first_slice,
                                                       .stride = context_.particles,
                                                       .unit = context_.unit,
                                                       .energies = s.energies,
                                                       .slice_begin = s.slice_begin,
                                                       .bond = s.bond,
                                                       .weight = s.weight,
                                                       .position = s.position,
                                                       .displacement = displacement,
                                                       .shape = s.shape,
                                                       .solver = s.solver,
                                                       .tangent = s.tangent});
  }
  void product(const LawRange& range, BufferStorage* direction) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::stretch_product::Args{.threads = range.count,
                                                       .first = range.first,
                                                       .first_slice = range.first_slice,
                                                       .unit = context_.unit,
                                                       .energies = s.energies,
                                                       .slice_begin = s.slice_begin,
                                                       .bond = s.bond,
                                                       .weight = s.weight,
                                                       .tangent = s.tangent,
                                                       .direction = direction,
                                                       .solver = s.solver,
                                                       .stretch_record = s.stretch_record});
    context_.device.run(kernels::stretch_product_force::Args{.threads = range.count,
                                                             .anisotropic = anisotropic_,
                                                             .first = range.first,
                                                             .first_slice = range.first_slice,
                                                             .unit = context_.unit,
                                                             .energies = s.energies,
                                                             .slice_begin = s.slice_begin,
                                                             .bond = s.bond,
                                                             .weight = s.weight,
                                                             .tangent = s.tangent,
                                                             .stretch_record = s.stretch_record,
                                                             .solver = s.solver,
                                                             .force = s.force,
                                                             .strength = s.strength});
  }

private:
  /// Where a line search looks at the potential, state() and force() find the energy on their way.
  BufferStorage* summed() const {
    return potential_ ? static_cast<BufferStorage*>(context_.state.energy) : nullptr;
  }
  bool alike(std::uint32_t i) const {
    const Model& model = context_.model;
    const auto begin = model.bonds.neighbour.begin();
    return std::all_of(begin + model.bonds.begin[i], begin + model.bonds.begin[i + 1],
                       [&](std::uint32_t j) { return model.material[j] == model.material[i]; });
  }
  // As `weight`: a row holds 16 strengths outwards, then 16 inwards.
  void upload_strengths() {
    const SlicedBonds bonds = slice_bonds(context_.model);
    std::vector<double> strength(2 * bonds.strength_out.size());
    for (std::size_t e = 0; e < bonds.strength_out.size(); ++e) {
      const std::size_t at = e / slice_width * 2 * slice_width + e % slice_width;
      strength[at] = bonds.strength_out[e];
      strength[at + slice_width] = bonds.strength_in[e];
    }
    context_.device.upload(context_.state.strength, strength);
  }

  bool anisotropic_, potential_;
};

} // namespace

std::unique_ptr<ElasticLaw> make_basis(const LawContext& context) {
  return std::make_unique<Basis>(context);
}

LawNeeds basis_needs(const LawRequest& request) {
  LawNeeds needs;
  needs.shape_rows = 3; // and the material's place in the table
  const std::uint32_t strong = anisotropic(request.model);
  needs.buffers = {{"stretch_record", Type::real4, 2 * request.model.count(), ""},
                   {"energies", Type::real4, table_rows, ""}};
  if (strong) needs.buffers.push_back({"strength", Type::real, 2 * request.bonds.weight_out.size(), ""});
  const std::uint32_t potential = request.potential;
  needs.kernel(kernels::stretch_state::Args{.potential = potential});
  needs.kernel(kernels::stretch_force::Args{.anisotropic = strong, .potential = potential});
  if (request.derivative) {
    needs.kernel(kernels::stretch_tangent::Args{});
    needs.kernel(kernels::stretch_product::Args{});
    needs.kernel(kernels::stretch_product_force::Args{.anisotropic = strong});
  }
  needs.energies.push_back(kernel_variant(kernels::stretch_energy::Args{.anisotropic = strong}, ""));
  return needs;
}

} // namespace pliant
