// Multifrontal Cholesky: each front gathers its entries of the matrix and what its children leave of theirs,
// eliminates its columns, and leaves the rest to its parent.
#include "engine/solver/cholesky.h"

#include "engine/core/error.h"

#include <Eigen/Dense>

#include <algorithm>
#include <atomic>
#include <memory>

namespace pliant {

namespace {

constexpr std::uint32_t block = 16;

using Dense = Eigen::MatrixXd;

std::uint32_t blocks_of(std::uint32_t count) {
  return (count + block - 1) / block;
}

/// Fronts by level, in the order of the dissection within one.
std::vector<std::vector<std::uint32_t>> by_level(const Dissection& d) {
  std::vector<std::vector<std::uint32_t>> levels(d.levels);
  for (std::uint32_t f = 0; f < d.fronts.size(); ++f) levels[d.fronts[f].level].push_back(f);
  return levels;
}

/// What is left of a front for its parent; gone once the parent has it.
using Remainders = std::vector<std::unique_ptr<Dense>>;

class Elimination {
public:
  Elimination(const Model& model, const Dissection& d, const FactorLayout& layout, double step,
              Factor& factor)
      : model_(model), d_(d), layout_(layout), stiffness_(diagonal_stiffness(model)), step_(step),
        factor_(factor), remainder_(d.fronts.size()) {}

  /// False where a pivot is not above zero.
  bool eliminate(std::uint32_t index) {
    const Front& f = d_.fronts[index];
    const std::uint32_t c = f.columns, r = f.rows(), total = c + r;
    Dense a = Dense::Zero(total, total); // its lower triangle
    gather(f, a);
    for (const std::int32_t child : f.child)
      if (child >= 0) add(f, static_cast<std::size_t>(child), a);
    Dense p(total, c);
    if (c > 0) {
      Dense pivot = a.topLeftCorner(c, c);
      const Eigen::LLT<Eigen::Ref<Dense>> cholesky(pivot);
      if (cholesky.info() != Eigen::Success) return false;
      const auto lower = pivot.triangularView<Eigen::Lower>();
      p.topRows(c).setIdentity();
      lower.solveInPlace(p.topRows(c));
      // L_rc = A_rc L_cc^-T; what is left is A_rr - L_rc L_rc^T.
      const Dense below = a.bottomLeftCorner(r, c) * p.topRows(c).triangularView<Eigen::Lower>().transpose();
      a.bottomRightCorner(r, r).selfadjointView<Eigen::Lower>().rankUpdate(below, -1);
      p.bottomRows(r).noalias() = -below * p.topRows(c).triangularView<Eigen::Lower>();
    }
    if (r > 0) remainder_[index] = std::make_unique<Dense>(a.bottomRightCorner(r, r));
    store(index, p);
    return true;
  }

private:
  /// The matrix in the front's columns: springs as stiff as bonds may get, and inertia.
  void gather(const Front& f, Dense& a) const {
    for (std::uint32_t column = 0; column < f.columns; ++column) {
      const std::uint32_t i = d_.order[f.first + column];
      a(column, column) = model_.mass[i] / (step_ * step_) + stiffness_[i];
      for (std::uint32_t bond = model_.bonds.begin[i]; bond < model_.bonds.begin[i + 1]; ++bond) {
        const std::uint32_t j = model_.bonds.neighbour[bond], place = d_.place[j];
        if (place != Dissection::nowhere && place > f.first + column)
          a(d_.within(f, place), column) -= spring(i, bond) + spring(j, model_.bonds.reverse[bond]);
      }
    }
  }
  double spring(std::uint32_t i, std::uint32_t bond) const {
    const double x2 = (model_.reference[model_.bonds.neighbour[bond]] - model_.reference[i]).squaredNorm();
    return bond_bound(model_, i, bond) * model_.constants[model_.material[i]].modulus * model_.volume[i] *
           model_.bonds.weight[bond] / x2;
  }

  void add(const Front& f, std::size_t child, Dense& a) {
    const Front& from = d_.fronts[child];
    const std::unique_ptr<Dense> left = std::move(remainder_[child]);
    std::vector<std::uint32_t> to(from.rows());
    for (std::uint32_t k = 0; k < from.rows(); ++k) to[k] = d_.within(f, d_.row[from.row_begin + k]);
    for (std::uint32_t column = 0; column < from.rows(); ++column)
      for (std::uint32_t row = column; row < from.rows(); ++row)
        a(to[row], to[column]) += (*left)(row, column);
  }

  void store(std::uint32_t index, const Dense& p) {
    const std::uint32_t c = d_.fronts[index].columns, total = static_cast<std::uint32_t>(p.rows());
    for (std::uint32_t b = 0; b < blocks_of(total); ++b) {
      const Uint4& at = layout_.up[layout_.first_up[index] + b];
      double* const to = factor_.up.data() + std::size_t{block} * at.x;
      for (std::uint32_t k = 0; k < at.z; ++k)
        for (std::uint32_t lane = 0; lane < std::min(block, total - block * b); ++lane)
          to[block * k + lane] = p(block * b + lane, k);
    }
    for (std::uint32_t b = 0; b < blocks_of(c); ++b) {
      const Uint4& at = layout_.down[layout_.first_down[index] + b];
      double* const to = factor_.down.data() + std::size_t{block} * at.x;
      for (std::uint32_t k = block * b; k < total; ++k)
        for (std::uint32_t lane = 0; lane < std::min(block, c - block * b); ++lane)
          to[block * (k - block * b) + lane] = p(k, block * b + lane);
    }
  }

  const Model& model_;
  const Dissection& d_;
  const FactorLayout& layout_;
  const std::vector<double> stiffness_;
  const double step_;
  Factor& factor_;
  Remainders remainder_;
};

} // namespace

FactorLayout lay_out(const Dissection& d) {
  FactorLayout layout;
  const auto fronts = static_cast<std::uint32_t>(d.fronts.size());
  std::uint32_t slots = 0;
  for (const Front& f : d.fronts) {
    layout.first_slot.push_back(slots);
    slots += block * blocks_of(f.columns + f.rows());
  }
  const std::uint32_t zero = slots;
  layout.slot.assign(std::size_t{slots} + 1, Uint4{0, zero, zero, 0});
  for (std::uint32_t index = 0; index < fronts; ++index) {
    const Front& f = d.fronts[index];
    const std::uint32_t first = layout.first_slot[index];
    for (std::uint32_t k = 0; k < f.columns; ++k)
      layout.slot[first + k] = {d.order[f.first + k], zero, zero, 1};
    for (std::uint32_t k = 0; k < f.rows(); ++k)
      layout.slot[first + f.columns + k] = {d.order[d.row[f.row_begin + k]], zero, zero, 0};
    for (std::uint32_t c = 0; c < 2; ++c) {
      if (f.child[c] < 0) continue;
      const auto child = static_cast<std::uint32_t>(f.child[c]);
      const Front& from = d.fronts[child];
      for (std::uint32_t k = 0; k < from.rows(); ++k) {
        Uint4& slot = layout.slot[first + d.within(f, d.row[from.row_begin + k])];
        (c == 0 ? slot.y : slot.z) = layout.first_slot[child] + from.columns + k;
      }
    }
  }
  layout.first_up.assign(fronts, 0);
  layout.first_down.assign(fronts, 0);
  for (const std::vector<std::uint32_t>& level : by_level(d)) {
    layout.up_begin.push_back(static_cast<std::uint32_t>(layout.up.size()));
    layout.down_begin.push_back(static_cast<std::uint32_t>(layout.down.size()));
    for (const std::uint32_t index : level) {
      const std::uint32_t c = d.fronts[index].columns, total = c + d.fronts[index].rows(),
                          first = layout.first_slot[index];
      layout.first_up[index] = static_cast<std::uint32_t>(layout.up.size());
      layout.first_down[index] = static_cast<std::uint32_t>(layout.down.size());
      for (std::uint32_t b = 0; b < blocks_of(total); ++b) {
        const std::uint32_t inputs = std::min(c, block * (b + 1));
        layout.up.push_back(
            {static_cast<std::uint32_t>(layout.coefficients_up / block), first, inputs, block * b});
        layout.coefficients_up += std::size_t{block} * inputs;
      }
      for (std::uint32_t b = 0; b < blocks_of(c); ++b) {
        layout.down.push_back(
            {static_cast<std::uint32_t>(layout.coefficients_down / block), first, total, block * b});
        layout.coefficients_down += std::size_t{block} * (total - block * b);
      }
    }
  }
  layout.up_begin.push_back(static_cast<std::uint32_t>(layout.up.size()));
  layout.down_begin.push_back(static_cast<std::uint32_t>(layout.down.size()));
  return layout;
}

Factor factorise(const Model& model, const Dissection& d, const FactorLayout& layout, double step) {
  Factor factor;
  factor.up.assign(layout.coefficients_up, 0);
  factor.down.assign(layout.coefficients_down, 0);
  Elimination elimination(model, d, layout, step, factor);
  std::atomic<bool> good = true;
  for (const std::vector<std::uint32_t>& level : by_level(d)) {
    const auto count = static_cast<std::int64_t>(level.size());
#pragma omp parallel for schedule(dynamic) if (count > 1)
    for (std::int64_t k = 0; k < count; ++k)
      if (good && !elimination.eliminate(level[static_cast<std::size_t>(k)])) good = false;
  }
  if (!good)
    throw Error(ExitCode::internal,
                "the direct solver's matrix could not be factorised: a mass or a stiffness of "
                "the scene is not a positive number");
  return factor;
}

} // namespace pliant
