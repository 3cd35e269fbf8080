// Samples ghost particles.
#include "engine/model/ghosts.h"

#include "engine/core/error.h"
#include "engine/scene/sample.h"
#include "engine/scene/shape.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace pliant {

namespace {

/// Points about a centre in given axes, `step` apart; in each direction `count` of them from `first` on.
struct GhostLattice {
  Vector3 centre = Vector3::Zero(), first = Vector3::Zero(), step = Vector3::Zero();
  Matrix3 axes = Matrix3::Identity();
  std::array<long long, 3> count = {1, 1, 1};

  Vector3 at(long long x, long long y, long long z) const {
    return centre + axes * (first + Vector3(double(x), double(y), double(z)).cwiseProduct(step));
  }
};

class GhostSampler {
public:
  GhostSampler(const Scene& scene, const Model& model)
      : scene_(scene), spacing_(model.spacing), flat_(model.dimension == 2),
        deepest_((scene.fluid.horizon - 0.5) * spacing_) {}

  std::vector<Ghost> all() {
    for (std::uint32_t b = 0; b < scene_.boundaries.size(); ++b) {
      const Boundary& boundary = scene_.boundaries[b];
      if (boundary.slip) continue;
      try {
        if (boundary.shape.kind == Shape::Kind::plane)
          of_plane(boundary.shape, b);
        else
          of_shape(boundary, b);
      } catch (const Error& error) {
        throw Error(error.code(), fmt::format("{}{}: boundary '{}': {}", scene_.file.string(),
                                              boundary.typed_at, boundary.name, error.what()));
      }
    }
    check_apart();
    return std::move(ghosts_);
  }

private:
  /// An obstacle that lies in another is one too many: ghosts of both would be felt.
  void check_apart() const {
    for (const auto& [b, points] : offered_)
      for (const auto& [a, others] : offered_) {
        const Boundary &inner = scene_.boundaries[b], &outer = scene_.boundaries[a];
        if (a == b || moves(inner.motion) || moves(outer.motion)) continue;
        const ShapeQuery query(outer.shape, scene_.file.parent_path());
        const double sense = outer.inside ? -1 : 1;
        if (std::all_of(points.begin(), points.end(),
                        [&](const Vector3& p) { return sense * query.signed_distance(p) < 1e-6 * spacing_; }))
          throw Error(
              ExitCode::usage,
              fmt::format("{}{}: boundary '{}': all of it lies in boundary '{}', so that their ghost "
                          "particles overlap: take one of them away, or give one condition = \"slip\"",
                          scene_.file.string(), inner.typed_at, inner.name, outer.name));
      }
  }
  static bool moves(const Motion& motion) { return motion.rate != 0 || !motion.velocity.isZero(0); }

  /// The domain and what reaches into it; in directions that repeat the domain alone.
  bool in_domain(const Vector3& p) const {
    const DomainSettings& domain = scene_.domain;
    if (!domain.given) return true;
    for (int a = 0; a < 3; ++a) {
      const double slack = 1e-9 * spacing_,
                   beyond = domain.periodic[static_cast<std::size_t>(a)] ? -slack : deepest_;
      if (p[a] < domain.low[a] - std::max(beyond, 0.0) - slack || p[a] >= domain.high[a] + beyond)
        return false;
    }
    return true;
  }

  using Cell = std::array<long long, 3>;
  Cell cell_of(const Vector3& p) const {
    const Vector3 at = p / (spacing_ / 2);
    return {static_cast<long long>(std::floor(at.x())), static_cast<long long>(std::floor(at.y())),
            static_cast<long long>(std::floor(at.z()))};
  }
  bool crowded(const Vector3& p, std::uint32_t boundary) const {
    const Cell cell = cell_of(p);
    for (long long z = -1; z <= 1; ++z)
      for (long long y = -1; y <= 1; ++y)
        for (long long x = -1; x <= 1; ++x) {
          const auto found = taken_.find({cell[0] + x, cell[1] + y, cell[2] + z});
          if (found == taken_.end()) continue;
          for (const std::uint32_t g : found->second)
            if (ghosts_[g].boundary != boundary && (ghosts_[g].place - p).norm() < 0.4999 * spacing_)
              return true;
        }
    return false;
  }

  void add(const Vector3& p, double depth, std::uint32_t boundary) {
    if (!(depth >= -1e-6 * spacing_ && depth < deepest_) || !in_domain(p)) return;
    offered_[boundary].push_back(p);
    if (crowded(p, boundary)) return;
    taken_[cell_of(p)].push_back(static_cast<std::uint32_t>(ghosts_.size()));
    ghosts_.push_back({p, std::max(depth, 0.0), boundary});
  }

  // Layers below the plane; along it the domain's box, in whole parts of a period where it repeats.
  void of_plane(const Shape& shape, std::uint32_t boundary) {
    const DomainSettings& domain = scene_.domain;
    if (!domain.given)
      throw Error(ExitCode::usage,
                  "fluids stick to a plane by particles that fill its part of the domain, and there "
                  "is none: add [domain] with low and high, or use a box");
    const Vector3 normal = shape.normal.normalized();
    int along = -1; // the axis that the plane is square to
    for (int a = 0; a < 3; ++a)
      if (std::abs(normal[a]) > 1 - 1e-12) along = a;
    GhostLattice lattice;
    const auto layers = static_cast<long long>(std::ceil(deepest_ / spacing_));
    if (along >= 0) {
      for (int a = 0; a < 3; ++a) {
        const auto k = static_cast<std::size_t>(a);
        if (a == along) {
          lattice.step[a] = normal[a] < 0 ? spacing_ : -spacing_;
          lattice.first[a] = shape.offset * normal[a] + lattice.step[a] / 2;
          lattice.count[k] = layers;
          continue;
        }
        const double length = domain.high[a] - domain.low[a];
        const double parts = std::max(1.0, std::round(length / spacing_));
        const auto margin = domain.periodic[k] ? 0 : layers;
        lattice.step[a] = domain.periodic[k] ? length / parts : spacing_;
        lattice.first[a] = domain.low[a] + (0.5 - double(margin)) * lattice.step[a];
        lattice.count[k] = static_cast<long long>(std::ceil(length / lattice.step[a] - 1e-6)) + 2 * margin;
        if (flat_ && a == 2) lattice.first[a] = 0, lattice.count[k] = 1;
      }
    } else {
      lattice.axes = Eigen::Quaterniond::FromTwoVectors(Vector3(0, 1, 0), normal).toRotationMatrix();
      const Vector3 middle = (domain.low + domain.high) / 2;
      lattice.centre = middle - (normal.dot(middle) - shape.offset) * normal;
      const auto half =
          static_cast<long long>(std::ceil((domain.high - domain.low).norm() / 2 / spacing_)) + layers;
      lattice.step = Vector3(spacing_, -spacing_, spacing_);
      lattice.first = spacing_ * Vector3(-double(half), -0.5, -double(half));
      lattice.count = {2 * half + 1, layers, 2 * half + 1};
      if (flat_) lattice.first.z() = 0, lattice.count[2] = 1;
    }
    for (long long z = 0; z < lattice.count[2]; ++z)
      for (long long y = 0; y < lattice.count[1]; ++y)
        for (long long x = 0; x < lattice.count[0]; ++x) {
          const Vector3 p = lattice.at(x, y, z);
          add(p, shape.offset - normal.dot(p), boundary);
        }
  }

  void of_shape(const Boundary& boundary, std::uint32_t index) {
    const auto folder = scene_.file.parent_path();
    const PlacedShape placed = pliant::place(boundary.shape, folder);
    const ShapeQuery query(boundary.shape, folder);
    const auto layers = static_cast<long long>(std::ceil(deepest_ / spacing_));
    GhostLattice lattice;
    lattice.centre = placed.centre, lattice.axes = placed.axes;
    lattice.step.setConstant(spacing_);
    for (int a = 0; a < 3; ++a) {
      // As bodies are filled: cells of a box whose edges are whole spacings lie against its faces.
      const auto cells = static_cast<long long>(std::llround(2 * placed.half[a] / spacing_));
      const long long margin = boundary.inside ? layers : 0;
      const long long count = std::max(cells, 1ll) + 2 * margin;
      lattice.count[static_cast<std::size_t>(a)] = count;
      lattice.first[a] = -0.5 * double(count - 1) * spacing_;
    }
    if (flat_) lattice.count[2] = 1, lattice.first.z() = 0;
    for (long long z = 0; z < lattice.count[2]; ++z)
      for (long long y = 0; y < lattice.count[1]; ++y)
        for (long long x = 0; x < lattice.count[0]; ++x) {
          Vector3 p = lattice.at(x, y, z);
          if (flat_) p.z() = 0;
          const double depth = (boundary.inside ? 1 : -1) * query.signed_distance(p);
          add(p, depth, index);
          // A distance changes by no more than one goes: what lies between is too deep, or outside.
          const double clear = std::max(depth - deepest_, -depth) / spacing_ - 1;
          if (clear >= 1) x += static_cast<long long>(clear);
        }
  }

  const Scene& scene_;
  double spacing_;
  bool flat_;
  double deepest_; ///< m: deeper ones have no fluid near
  std::vector<Ghost> ghosts_;
  std::map<Cell, std::vector<std::uint32_t>> taken_;
  std::map<std::uint32_t, std::vector<Vector3>> offered_; ///< of each boundary: those left out too
};

} // namespace

bool needs_ghosts(const Scene& scene) {
  bool viscous = false;
  for (const Body& body : scene.bodies)
    if (const Material* m = scene.material(body.material); m && m->fluid())
      viscous = viscous || m->viscosity > 0 || m->bonded();
  for (const Emitter& emitter : scene.emitters)
    if (const Material* m = scene.material(emitter.material))
      viscous = viscous || m->viscosity > 0 || m->bonded();
  return viscous && std::any_of(scene.boundaries.begin(), scene.boundaries.end(),
                                [](const Boundary& boundary) { return !boundary.slip; });
}

std::vector<Ghost> sample_ghosts(const Scene& scene, const Model& model) {
  return needs_ghosts(scene) ? GhostSampler(scene, model).all() : std::vector<Ghost>{};
}

} // namespace pliant
