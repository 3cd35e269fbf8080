// Law M1, projective, as He, Wang and Wu (2017) print it: no potential, so no derivative.
#include "engine/solver/elastic_law.h"
#include "engine/solver/state.h"
#include "kernels/projective_energy.h"
#include "kernels/projective_force.h"
#include "kernels/projective_state.h"

#include <Eigen/Eigenvalues>

namespace pliant {

namespace {

bool swaps_rows(const Material& material) {
  return material.inversion == "swap";
}

class Projective : public ElasticLaw {
public:
  explicit Projective(const LawContext& context) : ElasticLaw(context) {
    for (const Material& material : context.scene.materials) {
      if (material.law != law_name(Law::projective)) continue;
      deviatoric_ = material.split;
      swap_rows_ = swaps_rows(material);
    }
  }

  // Rows 2 to 7 of `shape`: pseudo-inverse of sum c x^2 xi (x) xi, cut at 1e-4 of its trace.
  void upload(const LawRange& range) override {
    const Model& model = context_.model;
    std::vector<double> rows(6 * std::size_t{range.count});
    for (std::uint32_t local = 0; local < range.count; ++local) {
      const std::uint32_t i = range.first + local;
      const double modulus = model.constants[model.material[i]].modulus * model.volume[i];
      Matrix3 tensor = Matrix3::Zero();
      for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
        const Vector3 xi = model.reference[model.bonds.neighbour[b]] - model.reference[i];
        tensor += modulus * model.bonds.weight[b] * xi * xi.transpose();
      }
      const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(tensor);
      Vector3 values = eigen.eigenvalues();
      const double cut = 1e-4 * values.sum();
      for (double& value : values) value = value > cut && value > 0 ? 1 / value : 0;
      const Matrix3 inverse = eigen.eigenvectors() * values.asDiagonal() * eigen.eigenvectors().transpose();
      const double six[] = {inverse(0, 0), inverse(0, 1), inverse(0, 2),
                            inverse(1, 1), inverse(1, 2), inverse(2, 2)};
      for (std::size_t r = 0; r < 6; ++r) rows[r * range.count + local] = six[r];
    }
    for (std::size_t r = 0; r < 6; ++r)
      context_.device.upload(context_.state.shape, std::span(rows).subspan(r * range.count, range.count),
                             (r + 2) * context_.particles + range.first);
  }
  void state(const LawRange& range, BufferStorage* displacement) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::projective_state::Args{.threads = range.count,
                                                        .swap_rows = swap_rows_,
                                                        .first = range.first,
                                                        .first_slice = range.first_slice,
                                                        .stride = context_.particles,
                                                        .unit = context_.unit,
                                                        .slice_begin = s.slice_begin,
                                                        .bond = s.bond,
                                                        .weight = s.weight,
                                                        .position = s.position,
                                                        .displacement = displacement,
                                                        .shape = s.shape,
                                                        .record = s.record,
                                                        .solver = s.solver});
  }
  void force(const LawRange& range) override {
    const SimulationState& s = context_.state;
    context_.device.run(kernels::projective_force::Args{.threads = range.count,
                                                        .first = range.first,
                                                        .first_slice = range.first_slice,
                                                        .unit = context_.unit,
                                                        .deviatoric = deviatoric_,
                                                        .slice_begin = s.slice_begin,
                                                        .bond = s.bond,
                                                        .weight = s.weight,
                                                        .position = s.position,
                                                        .record = s.record,
                                                        .linear_start = s.linear_start,
                                                        .force = s.force,
                                                        .solver = s.solver});
  }
  void energy(const LawRange& range, BufferStorage*, bool gated) override {
    const SimulationState& s = context_.state;
    context_.device.run(
        kernels::projective_energy::Args{.threads = range.count,
                                         .gated = gated,
                                         .first = range.first,
                                         .first_slice = range.first_slice,
                                         .unit = context_.unit,
                                         .deviatoric = deviatoric_,
                                         .gate = gated ? static_cast<BufferStorage*>(s.solver) : nullptr,
                                         .slice_begin = s.slice_begin,
                                         .bond = s.bond,
                                         .weight = s.weight,
                                         .position = s.position,
                                         .record = s.record,
                                         .energy = s.energy});
  }

private:
  double deviatoric_ = 0;  ///< share of the deviatoric term
  bool swap_rows_ = false; ///< the paper's row swap
};

} // namespace

std::unique_ptr<ElasticLaw> make_projective(const LawContext& context) {
  return std::make_unique<Projective>(context);
}

LawNeeds projective_needs(const LawRequest& request) {
  LawNeeds needs;
  needs.shape_rows = 8; // and six of the inverse shape tensor
  needs.buffers = {{"record", Type::real4, 3 * request.model.count(), ""}};
  const Material* last = nullptr; // the law's settings are those of the last material that has it
  for (const Material& material : request.scene.materials)
    if (material.law == law_name(Law::projective)) last = &material;
  needs.kernel(kernels::projective_state::Args{.swap_rows = last && swaps_rows(*last)});
  needs.kernel(kernels::projective_force::Args{});
  needs.energies = {kernel_variant(kernels::projective_energy::Args{}, "")};
  return needs;
}

} // namespace pliant
