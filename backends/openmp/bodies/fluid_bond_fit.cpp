// Eq. 20 in lengths; see kernels/fluid_bond_fit.decl.
#include "kernels/fluid_bond_fit.h"
#include "backends/openmp/body.h"
#include "backends/openmp/fluid_bonds.h"

namespace pliant::openmp::PLIANT_ISA {

namespace {

/// Bonds that are kept, of a part: visit(weight, n, |X|^2 / |Y|^2, e), with weight 0 where there is none.
template <bool repeats, class View, class Visit, class real = typename View::real>
PLIANT_INLINE void for_each_kept(const View& k, const Part<real>& part, const Wide4<real>& own, Visit visit) {
  const Wide<real> none{}, one = none + 1;
  for (uint r = 0; r < k.near_count[part.first / 16]; ++r) {
    const std::size_t entry = list_entry(k, part, r);
    const Wide<real> rest = load_wide(k.near_rest + entry);
    const Wide3<real> y = to_others<repeats>(k, own, gather_near(k.fluid_start, k.near + entry));
    const Wide<real> size2 = dot(y, y);
    const WideMask<real> kept = (rest > 0) & (size2 > real(SHORTEST_BOND));
    const Wide<real> size = root_wide<real>(kept ? size2 : one), x = kept ? rest : one;
    const Wide<real> both = 1 / (size * x), per = both * x,
                     stretch = size * (both * size); // one division for both
    const Wide<real> weight = bond_weights(k, size2), short_by = x * per;
    visit(kept ? weight : none, Wide3<real>{per * y.x, per * y.y, per * y.z}, Wide<real>(short_by * short_by),
          Wide<real>(stretch - 1));
  }
}

/// A symmetric tensor's coefficients along n.
template <class real> PLIANT_INLINE void directions(Wide<real> (&phi)[6], const Wide3<real>& n) {
  phi[0] = n.x * n.x, phi[1] = n.y * n.y, phi[2] = n.z * n.z;
  phi[3] = 2 * n.y * n.z, phi[4] = 2 * n.x * n.z, phi[5] = 2 * n.x * n.y;
}

/// A triangle of a symmetric matrix of six rows.
constexpr uint at(uint p, uint q) {
  return p * (p + 1) / 2 + q;
}
template <class real> struct Normal {
  Wide<real> m[21] = {}, right[6] = {};

  /// Adds to `a` what the factor `l` of the matrix and its ridge makes of what `a` leaves.
  PLIANT_INLINE void improve(const Wide<real> (&l)[21], Wide<real> (&a)[6]) const {
    Wide<real> x[6];
    for (uint p = 0; p < 6; ++p) {
      x[p] = right[p];
      for (uint q = 0; q < 6; ++q) x[p] -= m[q <= p ? at(p, q) : at(q, p)] * a[q];
    }
    for (uint p = 0; p < 6; ++p) {
      for (uint q = 0; q < p; ++q) x[p] -= l[at(p, q)] * x[q];
      x[p] /= l[at(p, p)];
    }
    for (uint p = 6; p-- > 0;) {
      for (uint q = p + 1; q < 6; ++q) x[p] -= l[at(q, p)] * x[q];
      x[p] /= l[at(p, p)];
      a[p] += x[p];
    }
  }
  PLIANT_INLINE void factorise(Wide<real> (&l)[21]) const {
    const Wide<real> least = spread(real(0.1 * FIT_RIDGE));
    for (uint p = 0; p < 6; ++p)
      for (uint q = 0; q <= p; ++q) {
        Wide<real> value = m[at(p, q)];
        if (p == q) value += real(FIT_RIDGE);
        for (uint c = 0; c < q; ++c) value -= l[at(p, c)] * l[at(q, c)];
        l[at(p, q)] = p == q ? root_wide<real>(value > least ? value : least) : value / l[at(q, q)];
      }
  }
};

template <bool repeats, class real> PLIANT_INLINE void fits(const kernels::fluid_bond_fit::View<real>& k) {
  const Wide<real> none{}, one = none + 1;
#pragma omp parallel for schedule(static)
  for (uint first = 0; first < k.threads; first += lanes<real>) {
    const Part<real> part = make_part<real>(first, k.threads - first);
    uint fresh = 0;
    for (uint r = 0; r < k.near_count[first / 16]; ++r)
      fresh |= bits<real>(load_wide(k.near_rest + list_entry(k, part, r)) < 0);
    if (!fresh) continue;
    const Wide4<real> own = gather(k.fluid_start, part.index);
    StrainSums<real> strains;
    Wide<real> ratios{};
    for_each_kept<repeats>(k, part, own,
                           [&](Wide<real> weight, const Wide3<real>&, Wide<real> ratio, Wide<real> strain) {
                             add_strain(strains, weight, strain);
                             ratios += weight * ratio;
                           });
    const WideMask<real> known = strains.weight > 0;
    const Wide<real> per = 1 / (known ? strains.weight : one), mean = ratios * per,
                     isotropic = strains.strain * per;
    const Wide<real> variance = strains.square * per - isotropic * isotropic;
    const Wide<real> rms = root_wide<real>(variance > 0 ? variance : none);
    Normal<real> normal;
    for_each_kept<repeats>(k, part, own,
                           [&](Wide<real> weight, const Wide3<real>& n, Wide<real> ratio, Wide<real>) {
                             Wide<real> phi[6];
                             directions<real>(phi, n);
                             const Wide<real> share = weight * per, off = ratio - mean;
                             for (uint p = 0; p < 6; ++p) {
                               const Wide<real> weighted = share * phi[p];
                               normal.right[p] += weighted * off;
                               for (uint q = 0; q <= p; ++q) normal.m[at(p, q)] += weighted * phi[q];
                             }
                           });
    Wide<real> l[21], a[6] = {};
    normal.factorise(l);
    for (uint pass = 0; pass < FIT_PASSES; ++pass) normal.improve(l, a);
    const auto bound = [&](Wide<real> stretch) {
      const Wide<real> least = spread(real(0.05));
      return known ? (stretch > least ? stretch : least) : one;
    };
    const Wide<real> low = bound(1 + isotropic - k.excess * rms),
                     high = bound(1 + isotropic + k.excess * rms);
    for (uint lane = 0; lane < part.count; ++lane) {
      if (!(fresh >> lane & 1)) continue;
      auto* const fit = k.fluid_fit + 2 * (std::size_t{first} + lane);
      const auto straight = [&](uint p) { return known[lane] ? mean[lane] + a[p][lane] : real(1); };
      const auto mixed = [&](uint p) { return known[lane] ? a[p][lane] : real(0); };
      fit[0] = {straight(0), straight(1), straight(2), mixed(3)};
      fit[1] = {mixed(4), mixed(5), low[lane], high[lane]};
    }
  }
}

} // namespace

template <class real> void fluid_bond_fit(const kernels::fluid_bond_fit::View<real>& k) {
  with_images(k, [&](auto repeats) { fits<repeats.value>(k); });
}

PLIANT_BODY(fluid_bond_fit)

} // namespace pliant::openmp::PLIANT_ISA
