// Two materials over basis functions in one range of particles, for the tests of stretch_* kernels.
#pragma once

#include "engine/model/stretch_energy.h"
#include "shaders/common/stretch.glsl"
#include "tests/support/kernel_bonds.h"

namespace pliant::test {

/// One takes the mean stretch and all kinds of terms, the other the root mean square; by turns. Bonds have
/// strengths of 1/2, 1 and 3/2.
struct StretchProblem {
  using Kind = BasisTerm::Kind;
  BondProblem p;
  StretchEnergy energy[2];
  Values in;
  int only = -1; ///< one material for all, 0 or 1; -1: by turns

  explicit StretchProblem(std::size_t size, int material = -1)
      : p("ordinary", size, kernel_seed + 60, true), only(material) {
    energy[0].volume.terms = {{Kind::A, 2, 0.25}, {Kind::log2, 1, 0.5}, {Kind::A, 1, -0.125}};
    energy[0].bond.terms = {{Kind::A, 4, 0.5}, {Kind::B, 1, 0.25}, {Kind::A, 1, 0.125}, {Kind::B, 3, 0.125}};
    energy[1].volume = saint_venant_kirchhoff_basis();
    energy[1].bond = saint_venant_kirchhoff_basis();
    energy[1].squared = true;
    in = p.bond_values;
    std::vector<double> table(4 * STRETCH_MATERIALS * STRETCH_ROWS, 0.0);
    const auto row = [&](std::size_t at, double n, double a, double b, double l) {
      table[4 * at] = n, table[4 * at + 1] = a, table[4 * at + 2] = b, table[4 * at + 3] = l;
    };
    row(STRETCH_VOLUME, 2, 0.25, 0, 0), row(STRETCH_VOLUME + 1, 1, -0.125, 0, 0.5);
    row(STRETCH_BOND, 4, 0.5, 0, 0), row(STRETCH_BOND + 1, 1, 0.125, 0.25, 0),
        row(STRETCH_BOND + 2, 3, 0, 0.125, 0);
    row(STRETCH_ROWS, 1, 0, 0, 0); // the second material takes the root mean square
    for (const std::size_t sum : {STRETCH_VOLUME, STRETCH_BOND})
      row(STRETCH_ROWS + sum, 3, 0, 1.5, 0), row(STRETCH_ROWS + sum + 1, 1, 0, -0.5, 0);
    in["energies"] = table;
    in["strength"] = std::vector<double>(in["weight"].size(), not_a_number);
    for (std::size_t k = 64; k < in["strength"].size(); ++k) // behind two rows of other ranges
      in["strength"][k] = 0.5 + 0.5 * static_cast<double>(k % 3);
  }

  std::size_t kind(std::size_t i) const { return only < 0 ? i % 2 : static_cast<std::size_t>(only); }
  /// With the half that says that all neighbours are of the material.
  double first_row(std::size_t i) const { return (kind(i) ? STRETCH_ROWS : 0) + (only < 0 ? 0 : 0.5); }
  /// G of the bond at place `at` of particle i's row, outwards or inwards: as a device finds it.
  double strength(std::size_t i, std::size_t at, bool inwards) const {
    const std::size_t slice = i / slice_width, lane = i % slice_width;
    const auto begin = static_cast<std::size_t>(in.at("slice_begin")[p.first_slice + slice]);
    return in.at("strength")[32 * (begin + at) + lane + (inwards ? 16 : 0)];
  }
  /// `shape` with its third row, the material's place in the table.
  std::vector<double> shape() const {
    std::vector<double> values = p.shape(3);
    for (std::size_t i = 0; i < p.count; ++i) values[2 * p.total + p.first + i] = first_row(i);
    return values;
  }
  /// How wrong f may be at s, where s is by `error` roundings.
  static double size_of(const BasisSum& sum, double s, double error) {
    double terms = 0;
    for (const BasisTerm& term : sum.terms) {
      const BasisSum alone{{term}};
      terms += std::abs(alone.value(s)) + std::abs(alone.first(s)) * error;
    }
    return terms;
  }
  /// Parts of a particle's energy: a value, and the size of what adds up to it.
  struct Part {
    double value = 0, size = 0;
  };
  Part stretching(std::size_t i, bool anisotropic) const {
    Part part;
    const BasisSum& h = energy[kind(i)].bond;
    for (std::size_t b = 0; b < p.bonds[i].size(); ++b) {
      const auto& bond = p.bonds[i][b];
      const double x = bond.reference.norm(), s = p.current(i, bond).norm() / x;
      const double factor = bond.out * x * x * (anisotropic ? strength(i, b, false) : 1) / 2;
      part.value += factor * h.value(s);
      part.size += factor * size_of(h, s, s + 1);
    }
    return part;
  }
  Part volumetric(std::size_t i) const {
    if (p.bonds[i].empty()) return {};
    const Dilatation d = dilatation(i);
    const BasisSum& g = energy[kind(i)].volume;
    return {g.value(1 + d.e) / (2 * p.inverse_modulus[i]),
            size_of(g, 1 + d.e, d.size + 1) / (2 * p.inverse_modulus[i])};
  }
  /// The dilatation less one, and the size of what adds up to it.
  struct Dilatation {
    double e = 0, size = 0;
  };
  Dilatation dilatation(std::size_t i) const {
    Dilatation d;
    for (const auto& bond : p.bonds[i]) {
      const double x = bond.reference.norm(), y = p.current(i, bond).norm(),
                   c = p.inverse_modulus[i] * bond.out;
      d.e += kind(i) ? c * (y * y - x * x) / 2 : c * x * (y - x);
      d.size += c * (kind(i) ? y * y + x * x : x * (y + x));
    }
    if (kind(i)) d.e = std::sqrt(1 + 2 * d.e) - 1;
    return d;
  }
};

} // namespace pliant::test
