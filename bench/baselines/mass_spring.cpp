// Mass-spring system: a Hookean spring along each bond, stepped with implicit Euler. Each step minimises
//
//   Phi(y) = |y - y*|^2_M / 2 h^2 + sum of k/2 (|y_j - y_i| - L)^2
//
// (Liu, Bargteil, O'Brien and Kavan 2013) by Newton's method with conjugate gradients, compressed
// springs without their negative lateral stiffness (Choi and Ko 2002), and Armijo's condition: so that what
// it cannot do is the model's fault and not the integrator's.
//
// Stiffness: springs of k = 6 E (V_i w_ij + V_j w_ji) / L^2, weights matched to the fourth moments of an
// isotropic neighbourhood, return the Young's modulus typed; their Poisson's ratio is 1/4 whatever is typed.
#include "bench/baselines/baseline.h"

#include <cmath>

namespace pliant::bench {
namespace {

struct Spring {
  std::uint32_t i, j;
  double length, stiffness; // m, N/m
};

class MassSpring : public Baseline {
public:
  MassSpring(const Scene& scene, const Model& model) : Baseline(scene, model), total_(model.count(), 0) {
    Bonds bonds = model.bonds;
    compute_weights(bonds, model.reference, model.spacing, Law::ordinary, scene.simulation.weights,
                    scene.simulation.weight_exponent);
    for (std::uint32_t i = 0; i < model.count(); ++i)
      for (std::uint32_t b = bonds.begin[i]; b < bonds.begin[i + 1]; ++b) {
        const std::uint32_t j = bonds.neighbour[b];
        if (j < i) continue;
        const double length = (model.reference[j] - model.reference[i]).norm();
        const double share =
            typed_material(scene, model, i).young * model.volume[i] * bonds.weight[b] +
            typed_material(scene, model, j).young * model.volume[j] * bonds.weight[bonds.reverse[b]];
        const double stiffness = 6 * share / (length * length);
        springs_.push_back({i, j, length, stiffness});
        total_[i] += stiffness, total_[j] += stiffness;
      }
  }

protected:
  void step(double h) override {
    const Points target = inertial_target(h);
    const std::size_t count = target.size();
    Points y(count);
    for (std::size_t i = 0; i < count; ++i) {
      free_.resize(count);
      free_[i] = !held(i, time_ + h);
      y[i] = free_[i] ? Vector3(position_[i] + h * velocity_[i]) : target[i];
    }
    double first = 0, phi = potential(y, target, h);
    for (int newton = 0; newton < newton_cap; ++newton) {
      const Points r = residual(y, target, h);
      const double size = norm(r, h);
      if (newton == 0) first = size;
      if (!(size > tolerance * first)) break;
      const Points p = solve(y, r, h, std::min(0.1, std::sqrt(size / first)));
      double slope = 0, alpha = 1, next = 0;
      for (std::size_t i = 0; i < count; ++i) slope += r[i].dot(p[i]);
      Points trial(count);
      bool descends = false;
      for (int halving = 0; halving < 12 && !descends; ++halving, alpha /= 2) {
        for (std::size_t i = 0; i < count; ++i) trial[i] = y[i] + alpha * p[i];
        next = potential(trial, target, h);
        descends = next <= phi - 1e-4 * alpha * slope;
      }
      if (!descends) break;
      y = trial, phi = next;
    }
    take(y, h);
    collide(h);
  }

private:
  static constexpr int newton_cap = 50, gradient_cap = 2000;
  static constexpr double tolerance = 1e-4; // of the residual, relative to its first

  double potential(const Points& y, const Points& target, double h) const {
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i)
      sum += model_.mass[i] / (2 * h * h) * (y[i] - target[i]).squaredNorm();
    for (const Spring& s : springs_)
      sum += s.stiffness / 2 * std::pow((y[s.j] - y[s.i]).norm() - s.length, 2);
    return sum;
  }
  /// -dPhi/dy, N; zero where held.
  Points residual(const Points& y, const Points& target, double h) const {
    Points r(y.size());
    for (std::size_t i = 0; i < y.size(); ++i) r[i] = model_.mass[i] / (h * h) * (target[i] - y[i]);
    for (const Spring& s : springs_) {
      const Vector3 bond = y[s.j] - y[s.i];
      const double now = bond.norm();
      if (!(now > 0)) continue; // no direction to push in
      const Vector3 force = s.stiffness * (1 - s.length / now) * bond;
      r[s.i] += force, r[s.j] -= force;
    }
    release_held(r);
    return r;
  }
  void release_held(Points& r) const {
    for (std::size_t i = 0; i < r.size(); ++i)
      if (!free_[i]) r[i].setZero();
  }
  double weight(std::size_t i, double h) const { return 1 / (model_.mass[i] / (h * h) + total_[i]); }
  double norm(const Points& r, double h) const {
    double sum = 0;
    for (std::size_t i = 0; i < r.size(); ++i) sum += weight(i, h) * r[i].squaredNorm();
    return std::sqrt(sum);
  }
  /// The second derivative of Phi times p.
  Points product(const Points& y, const Points& p, double h) const {
    Points q(p.size());
    for (std::size_t i = 0; i < p.size(); ++i) q[i] = model_.mass[i] / (h * h) * p[i];
    for (const Spring& s : springs_) {
      const Vector3 bond = y[s.j] - y[s.i], d = p[s.j] - p[s.i];
      const double now = bond.norm();
      if (!(now > 0)) continue;
      const Vector3 n = bond / now;
      const double lateral = std::max(1 - s.length / now, 0.0);
      const Vector3 force = s.stiffness * (lateral * d + (1 - lateral) * n.dot(d) * n);
      q[s.i] -= force, q[s.j] += force;
    }
    release_held(q);
    return q;
  }
  /// Conjugate gradients, diagonal preconditioner.
  Points solve(const Points& y, Points r, double h, double relative) const {
    const std::size_t count = r.size();
    Points x(count, Vector3::Zero()), p(count);
    double rz = 0;
    for (std::size_t i = 0; i < count; ++i) p[i] = weight(i, h) * r[i], rz += r[i].dot(p[i]);
    const double stop = relative * relative * rz;
    for (int k = 0; k < gradient_cap && rz > stop; ++k) {
      const Points q = product(y, p, h);
      double curvature = 0, next = 0;
      for (std::size_t i = 0; i < count; ++i) curvature += p[i].dot(q[i]);
      const double alpha = rz / curvature;
      for (std::size_t i = 0; i < count; ++i) {
        x[i] += alpha * p[i], r[i] -= alpha * q[i];
        next += weight(i, h) * r[i].squaredNorm();
      }
      for (std::size_t i = 0; i < count; ++i) p[i] = weight(i, h) * r[i] + next / rz * p[i];
      rz = next;
    }
    return x;
  }

  std::vector<Spring> springs_;
  std::vector<double> total_; // N/m, of each particle's springs
  std::vector<bool> free_;
};

} // namespace

std::unique_ptr<Baseline> make_mass_spring(const Scene& scene, const Model& model) {
  return std::make_unique<MassSpring>(scene, model);
}

} // namespace pliant::bench
