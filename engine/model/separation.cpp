// The work of parting two halves; see separation.h.
#include "engine/model/separation.h"

#include "engine/core/error.h"

#include <algorithm>
#include <cmath>

namespace pliant {

Separation::Separation(Law law, const LawConstants& constants, const StretchEnergy& energy, BondSet bonds)
    : law_(law), constants_(constants), energy_(energy), bonds_(std::move(bonds)) {
  if (law == Law::projective || law == Law::neo_hookean)
    throw Error(ExitCode::internal, "what it takes to part a law whose bonds do not break");
  if (law != Law::ordinary) return; // a sum of B_1 = (s - 1)^2
  energy_ = {};
  energy_.bond = {{parse_basis("B1")}};
  energy_.volume = energy_.bond.scaled(constants.coupling);
}

// W of a particle whose bonds have come to y, J/m3; those that are not whole count as unstretched.
double Separation::density(const std::vector<Vector3>& y, const std::vector<char>& whole) const {
  const BondSet& n = bonds_;
  const double stiffness = constants_.modulus / 2;
  const auto each = [&](auto visit) { // weight, xi / x, Y / x, strength
    for (std::size_t b = 0; b < y.size(); ++b) {
      const double x = n.bond[b].norm();
      if (whole[b])
        visit(n.weight[b], Vector3(n.bond[b] / x), Vector3(y[b] / x),
              n.strength.empty() ? 1.0 : n.strength[b]);
    }
  };
  double value = 0, excess = 0;
  if (law_ == Law::corotated) {
    Matrix3 s = Matrix3::Zero();
    each([&](double w, const Vector3& x, const Vector3& to, double) { s += w * to * x.transpose(); });
    const Matrix3 r = nearest_rotation(s);
    each([&](double w, const Vector3& x, const Vector3& to, double) {
      const Vector3 turned = r * x;
      excess += w * (to.dot(turned) - 1);
      value += w * (to - turned).squaredNorm();
    });
    return stiffness * (value + constants_.coupling * excess * excess);
  }
  each([&](double w, const Vector3&, const Vector3& to, double strength) {
    const double stretch = to.norm();
    excess += w * (energy_.squared ? (stretch * stretch - 1) / 2 : stretch - 1);
    value += w * strength * energy_.bond.value(stretch);
  });
  const double theta = energy_.squared ? std::sqrt(std::max(1 + 2 * excess, 0.0)) : 1 + excess;
  return stiffness * (value + energy_.volume.value(theta));
}

// Of the half that is left behind. A particle at depth z has the bonds of xi . n > z across the cut, so that
// its layers are the intervals between the reaches of its bonds, each as thick as it is wide.
double Separation::half(double stretch, const Vector3& normal) const {
  const std::size_t count = bonds_.bond.size();
  std::vector<double> reach(count), opening(count); // the gap at which a bond breaks
  double longest = 0;
  for (std::size_t b = 0; b < count; ++b) {
    reach[b] = bonds_.bond[b].dot(normal);
    opening[b] =
        -reach[b] + std::sqrt(reach[b] * reach[b] + bonds_.bond[b].squaredNorm() * stretch * (2 + stretch));
    longest = std::max(longest, bonds_.bond[b].norm());
  }
  // Equal but for rounding: broken at once, of the same layer.
  const auto distinct = [](std::vector<double> values, double grain) {
    std::sort(values.begin(), values.end());
    std::vector<double> kept;
    for (const double value : values)
      if (kept.empty() || value > kept.back() + grain) kept.push_back(value);
    return kept;
  };
  const double thinnest = 1e-9 * longest;
  std::vector<double> layers, gaps;
  for (std::size_t b = 0; b < count; ++b)
    if (reach[b] > thinnest) layers.push_back(reach[b]), gaps.push_back(opening[b]);
  layers = distinct(layers, thinnest);
  gaps = distinct(gaps, thinnest * stretch);
  std::vector<Vector3> y(count);
  std::vector<char> whole(count), ends(count);
  double total = 0, from = 0;
  for (const double to : layers) {
    const double depth = (from + to) / 2;
    for (const double gap : gaps) {
      bool breaks = false;
      for (std::size_t b = 0; b < count; ++b) {
        const double still = reach[b] > depth ? opening[b] - gap : longest; // to go
        ends[b] = std::abs(still) <= 2 * thinnest * stretch;
        breaks = breaks || ends[b];
        whole[b] = ends[b] || still > 0;
        y[b] = reach[b] > depth ? Vector3(bonds_.bond[b] + gap * normal) : bonds_.bond[b];
      }
      if (!breaks) continue;
      const double before = density(y, whole);
      for (std::size_t b = 0; b < count; ++b) whole[b] = whole[b] && !ends[b];
      total += (to - from) * (before - density(y, whole));
    }
    from = to;
  }
  return total;
}

double Separation::work(double stretch, const Vector3& normal) const {
  return half(stretch, normal) + half(stretch, -normal);
}

// The root of the work is nearly proportional to the stretch, so that secants find it soon.
double Separation::critical_stretch(double energy, const std::vector<Vector3>& normals) const {
  const auto relative = [&](double stretch) {
    double sum = 0;
    for (const Vector3& normal : normals) sum += work(stretch, normal);
    return std::sqrt(sum / static_cast<double>(normals.size()) / energy);
  };
  double before = 0, of_before = 0, stretch = 1e-4;
  for (int round = 0; round < 60; ++round) {
    const double of_this = relative(stretch);
    if (std::abs(of_this - 1) < 1e-10 || of_this == of_before) break;
    const double slope = (of_this - of_before) / (stretch - before);
    before = stretch, of_before = of_this;
    stretch += (1 - of_this) / slope;
  }
  return stretch;
}

} // namespace pliant
