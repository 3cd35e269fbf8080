// Judges one run of the sweep.
#include "engine/model/initial_state.h"
#include "engine/report/stability.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pliant {

namespace {

Vector3 mean_velocity(const StabilitySetup& setup) {
  return centre_of_mass(setup.velocity, setup.model.mass);
}

double rms_strain(const Model& model, const std::vector<Vector3>& y) {
  double sum = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i)
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model.bonds.neighbour[b];
      const double e = (y[j] - y[i]).norm() / (model.reference[j] - model.reference[i]).norm() - 1;
      sum += e * e;
    }
  return model.bonds.count() == 0 ? 0 : std::sqrt(sum / static_cast<double>(model.bonds.count()));
}

/// Share of particles that are not inside out. Those whose neighbours lie in a plane or on a line have no
/// inside.
double upright_share(const Model& model, const std::vector<Vector3>& y) {
  std::size_t upright = 0;
  for (std::uint32_t i = 0; i < model.count(); ++i) {
    Matrix3 shape = Matrix3::Zero(), now = Matrix3::Zero();
    for (std::uint32_t b = model.bonds.begin[i]; b < model.bonds.begin[i + 1]; ++b) {
      const std::uint32_t j = model.bonds.neighbour[b];
      const Vector3 xi = model.reference[j] - model.reference[i];
      const double weight = model.bonds.weight[b] / xi.squaredNorm();
      shape += weight * xi * xi.transpose();
      now += weight * (y[j] - y[i]) * xi.transpose();
    }
    const double full = std::pow(shape.trace() / 3, 3);
    const Matrix3 axes = model.bodies[model.body[i]].axes; // of the reference; a rotation
    if (shape.determinant() < 1e-6 * full || (now * axes.transpose()).determinant() > 0) ++upright;
  }
  return model.count() == 0 ? 1 : static_cast<double>(upright) / static_cast<double>(model.count());
}

} // namespace

StabilityWatch::StabilityWatch(const StabilitySetup& setup, unsigned steps)
    : setup_(setup), steps_(steps), centre_(centre_of_mass(setup.position, setup.model.mass)),
      velocity_(mean_velocity(setup)), last_(setup.position) {}

/// How far free fall has carried by step n: implicit Euler's own sum.
Vector3 StabilityWatch::fallen(const Vector3& velocity, unsigned n, double step) const {
  const double steps = n;
  return velocity * (step * steps) +
         setup_.scene.simulation.gravity * (step * step * steps * (steps + 1) / 2);
}

bool StabilityWatch::after(unsigned n, double step, const std::vector<Vector3>& positions) {
  taken_ = n;
  step_ = step;
  const bool finite =
      std::all_of(positions.begin(), positions.end(), [](const Vector3& y) { return y.allFinite(); });
  if (!finite) {
    if (not_finite_at_ == 0) not_finite_at_ = n;
    return false;
  }
  const Vector3 centre = setup_.own_centre ? centre_of_mass(positions, setup_.model.mass)
                                           : Vector3(centre_ + fallen(velocity_, n, step));
  for (const Vector3& y : positions) farthest_ = std::max(farthest_, (y - centre).norm() / setup_.size);
  if (lost_at_ == 0 && !(farthest_ <= stability_reach)) lost_at_ = n;
  if (n == steps_ / 2) middle_ = positions;
  last_ = positions;
  return true;
}

/// What of the end is not as wanted; empty where nothing is.
std::string StabilityWatch::missed(const StabilityCell& cell) const {
  const double spacing = setup_.model.spacing;
  switch (setup_.wanted) {
  case Wanted::nothing:
    return {};
  case Wanted::shape:
    if (!(cell.strain < stability_strain)) return fmt::format("rms strain {:.2g} is left", cell.strain);
    if (!(cell.upright >= stability_upright))
      return fmt::format("{:.1f} % of the particles are inside out", 100 * (1 - cell.upright));
    return {};
  case Wanted::fall: {
    double worst = 0;
    for (std::size_t i = 0; i < last_.size(); ++i)
      worst =
          std::max(worst, (last_[i] - setup_.position[i] - fallen(setup_.velocity[i], taken_, step_)).norm());
    const double way = fallen(velocity_, taken_, step_).norm();
    return worst <= 1e-5 * way ? "" : fmt::format("{:.2g} m off free fall over {:.3g} m", worst, way);
  }
  case Wanted::still: {
    double moved = 0;
    for (std::size_t i = 0; i < middle_.size(); ++i) moved = std::max(moved, (last_[i] - middle_[i]).norm());
    return moved <= 0.01 * spacing ? "" : fmt::format("moved by {:.2g} spacings at rest", moved / spacing);
  }
  case Wanted::stack: {
    double top = -1e300, bottom = 1e300, lowest = 1e300;
    for (std::size_t i = 0; i < last_.size(); ++i) {
      if (i >= setup_.upper_first)
        bottom = std::min(bottom, last_[i].y());
      else
        top = std::max(top, last_[i].y()), lowest = std::min(lowest, last_[i].y());
    }
    if (lowest < 0) return fmt::format("{:.2g} spacings in the floor", 0.5 - lowest / spacing);
    const double overlap = setup_.scene.contact.distance - (bottom - top) / spacing;
    if (overlap > 0.5) return fmt::format("bodies overlap by {:.2g} spacings", overlap);
    return cell.upright >= stability_upright ? "" : "particles are inside out";
  }
  }
  return {};
}

void StabilityWatch::judge(StabilityCell& cell) const {
  cell.steps = taken_;
  cell.finite = not_finite_at_ == 0;
  cell.bounded = cell.finite && lost_at_ == 0;
  cell.recovery_wanted = setup_.wanted != Wanted::nothing;
  cell.farthest = farthest_;
  cell.strain = rms_strain(setup_.model, last_);
  cell.upright = upright_share(setup_.model, last_);
  if (!cell.finite) {
    cell.message = fmt::format("not finite from step {}", not_finite_at_);
  } else if (!cell.bounded) {
    cell.message = fmt::format("farther than {:g} body sizes from step {}, {:.3g} at most", stability_reach,
                               lost_at_, farthest_);
  } else {
    cell.message = missed(cell);
  }
  cell.recovered = cell.bounded && cell.message.empty();
  if (cell.recovered && !cell.recovery_wanted)
    cell.recovered = cell.strain < stability_strain && cell.upright >= stability_upright;
}

} // namespace pliant
