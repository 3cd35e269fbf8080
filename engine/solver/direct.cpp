// Factorises and solves.
#include "engine/solver/direct.h"

#include "engine/core/error.h"
#include "engine/core/memory.h"
#include "engine/solver/state.h"
#include "shaders/common/solver.glsl"

#include <Eigen/SparseCholesky>
#ifdef PLIANT_HAS_CHOLMOD
#include <Eigen/CholmodSupport>
#endif

#include <fmt/format.h>

namespace pliant {

namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

#ifdef PLIANT_HAS_CHOLMOD
/// Shows what the symbolic factorisation found.
class Cholesky : public Eigen::CholmodSupernodalLLT<Matrix, Eigen::Lower> {
public:
  double entries() { return cholmod().lnz; }
};
#else
class Cholesky : public Eigen::SimplicialLLT<Matrix, Eigen::Lower> {
public:
  double entries() const { return m_nonZerosPerCol.template cast<double>().sum(); }
};
#endif

} // namespace

struct Direct::Factor {
  Cholesky cholesky;
};

const char* Direct::library() {
#ifdef PLIANT_HAS_CHOLMOD
  return "CHOLMOD";
#else
  return "Eigen";
#endif
}

Direct::Direct(const SolveContext& context) : Preconditioner(context), held_(context.model.count(), false) {
  if (context.device.info().backend != "openmp")
    throw Error(ExitCode::usage,
                "the direct solver factorises a matrix on the CPU; on backend \"" +
                    context.device.info().backend +
                    "\" choose chebyshev, jacobi, position, lbfgs or newton, or --backend openmp");
  for (const Held& entry : context.model.held) held_[entry.particle] = true;
}

Direct::~Direct() = default;

void Direct::begin(const SolveBounds& bounds) {
  if (factor_ && bounds.step == step_) return;
  step_ = bounds.step;
  const Model& model = context_.model;
  const std::vector<double> stiffness = diagonal_stiffness(model);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(model.count() + model.bonds.count() / 2);
  const auto spring = [&](std::uint32_t i, std::uint32_t bond) {
    const LawConstants& law = model.constants[model.material[i]];
    const double x2 = (model.reference[model.bonds.neighbour[bond]] - model.reference[i]).squaredNorm();
    return bond_bound(model, i, bond) * law.modulus * model.volume[i] * model.bonds.weight[bond] / x2;
  };
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    const double inertia = model.mass[i] / (step_ * step_);
    entries.emplace_back(i, i, inertia + stiffness[i]);
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model.bonds.neighbour[b];
      if (j < i && !held_[i] && !held_[j]) // a held particle's row is not solved
        entries.emplace_back(i, j, -(spring(i, b) + spring(j, model.bonds.reverse[b])));
    }
  }
  const auto n = static_cast<Eigen::Index>(model.count());
  Matrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  entries = {};
  factor_ = std::make_unique<Factor>();
  factor_->cholesky.analyzePattern(matrix);
  const double bytes = 12 * factor_->cholesky.entries(); // values, and their share of indices
  require_memory(fmt::format("the direct solver's factor of {} particles needs", model.count()), bytes,
                 available_memory(), model.spacing);
  factor_->cholesky.factorize(matrix);
  if (factor_->cholesky.info() != Eigen::Success)
    throw Error(ExitCode::internal,
                "the direct solver's matrix could not be factorised: a mass or a stiffness of "
                "the scene is not a positive number");
}

void Direct::apply() {
  Device& device = context_.device;
  SimulationState& s = context_.state;
  device.enter("direct");
  if (device.download_real(s.solver, SOLVER_LINEAR, 1)[0] == 0) return;
  const std::vector<Real4<double>> r = device.download_real4(s.residual);
  const auto n = static_cast<Eigen::Index>(r.size());
  Columns right(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Real4<double>& v = r[static_cast<std::size_t>(i)];
    right.row(i) << v.x, v.y, v.z;
  }
  const Columns z = factor_->cholesky.solve(right);
  std::vector<Real4<double>> result(r.size());
  for (std::size_t i = 0; i < r.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    result[i] = held_[i] ? Real4<double>{0, 0, 0, 0} : Real4<double>{z(row, 0), z(row, 1), z(row, 2), 0};
  }
  device.upload(s.preconditioned, result);
  std::vector<Real4<double>> sums(s.solve_partial.count(), Real4<double>{0, 0, 0, 0});
  sums[0].x = right.cwiseProduct(z).sum();
  device.upload(s.solve_partial, sums);
}

} // namespace pliant
