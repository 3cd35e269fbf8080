// Connected components cut into chunks of odd sizes, with positions, targets and displacements: what is left
// of a step's momentum, summed, turned into a rigid motion, and taken out.
#pragma once

#include "tests/support/kernel_particles.h"

namespace pliant::test {

struct ComponentProblem {
  std::vector<std::pair<std::size_t, std::size_t>> ranges; ///< particles of each component
  std::vector<double> chunk, component, position, displacement, target;
  std::size_t count = 0, chunks = 0;

  /// Each component's displacement is its target and a small rigid motion: sizes of the shift, m, and the
  /// angle, rad.
  ComponentProblem(const std::vector<std::size_t>& sizes, unsigned seed, double shift, double angle) {
    Random random(seed);
    for (std::size_t c = 0; c < sizes.size(); ++c) {
      const std::size_t first_chunk = chunks, first = count, longest = 1 + sizes[c] / 3 + 40 * c;
      for (std::size_t begin = 0; begin < sizes[c]; begin += longest, ++chunks)
        chunk.insert(chunk.end(), {double(first + begin), double(first + std::min(sizes[c], begin + longest)),
                                   double(c), 0});
      component.insert(component.end(), {double(first_chunk), double(chunks), 1, 0});
      ranges.emplace_back(first, first + sizes[c]);
      count += sizes[c];
      const Vector3 away = random.vector(0.3), moved = random.vector(shift), turned = random.vector(angle);
      for (std::size_t i = 0; i < sizes[c]; ++i) {
        const Vector3 y = away + random.vector(0.2), goal = random.vector(0.02);
        // The rotation is about the component's own middle, which the random places share nearly.
        const Vector3 u = goal + moved + turned.cross(y + goal - away);
        add(position, y, rounded(0.5 + random(0.25)));
        add(target, goal, 100);
        add(displacement, u, 0);
      }
    }
  }
  Vector3 y(std::size_t i) const { return vector_at(position, i) + vector_at(displacement, i); }
  Vector3 rest(std::size_t i) const { return vector_at(displacement, i) - vector_at(target, i); }
  double mass(std::size_t i) const { return position[4 * i + 3]; }

  /// The five rows of sums over particles [begin, end), with the sums of magnitudes.
  struct Moments {
    Vector3 drift = Vector3::Zero(), centre = Vector3::Zero(), spin = Vector3::Zero(),
            square = Vector3::Zero(), mixed = Vector3::Zero();
    double mass = 0, size_drift = 0, size_centre = 0, size_spin = 0, size_square = 0;
  };
  Moments moments(std::size_t begin, std::size_t end) const {
    Moments s;
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3 at = y(i), d = rest(i);
      const double size_y = vector_at(position, i).norm() + vector_at(displacement, i).norm();
      const double size_d = vector_at(displacement, i).norm() + vector_at(target, i).norm();
      s.mass += mass(i);
      s.drift += mass(i) * d;
      s.centre += mass(i) * at;
      s.spin += mass(i) * at.cross(d);
      s.square += mass(i) * at.cwiseProduct(at);
      s.mixed += mass(i) * Vector3(at.x() * at.y(), at.x() * at.z(), at.y() * at.z());
      s.size_drift += mass(i) * size_d;
      s.size_centre += mass(i) * size_y;
      s.size_spin += mass(i) * size_y * size_d;
      s.size_square += mass(i) * size_y * size_y;
    }
    return s;
  }

private:
  static void add(std::vector<double>& groups, const Vector3& v, double w) {
    groups.insert(groups.end(), {rounded(v.x()), rounded(v.y()), rounded(v.z()), w});
  }
};

} // namespace pliant::test
