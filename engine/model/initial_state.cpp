// Initial deformation and motion of a body.
#include "engine/model/initial_state.h"

#include "engine/core/error.h"

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace pliant {

namespace {

/// Any number will do; a fixed one makes a failure repeatable.
constexpr std::uint64_t random_seed = 20170901;

/// A number in [0, 1) for each index: SplitMix64 (Steele, Lea, Flood 2014).
double uniform(std::uint64_t index) {
  std::uint64_t z = random_seed + (index + 1) * 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

void scatter(BodyParticles& particles) {
  Vector3 low = particles.position.front(), high = low;
  for (const Vector3& p : particles.position) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  for (std::size_t i = 0; i < particles.position.size(); ++i) {
    const std::uint64_t at = 3 * std::uint64_t{particles.arrangement.original[i]};
    particles.position[i] =
        low + Vector3(uniform(at), uniform(at + 1), uniform(at + 2)).cwiseProduct(high - low);
  }
}

void deform_part(const DeformedPart& part, BodyParticles& particles) {
  std::vector<Vector3> position;
  std::vector<double> mass;
  for (const std::uint32_t i : part.particles) {
    position.push_back(particles.position[i]);
    mass.push_back(particles.mass[i]);
  }
  const Vector3 centre = part.region->about.value_or(centre_of_mass(position, mass));
  for (const std::uint32_t i : part.particles)
    particles.position[i] = centre + part.region->deform * (particles.position[i] - centre);
}

void start_from(const std::string& start, const Vector3& centre, BodyParticles& particles) {
  if (start.empty()) return;
  if (start == "random") return scatter(particles);
  Vector3 keep; // factor of each component of the distance from the centre
  if (start == "flat")
    keep = {0, 1, 1};
  else if (start == "line")
    keep = {0, 1, 0};
  else if (start == "point")
    keep = {0, 0, 0};
  else if (start == "mirror")
    keep = {-1, 1, 1};
  else
    throw Error(
        ExitCode::usage,
        fmt::format("start is \"flat\", \"line\", \"point\", \"random\" or \"mirror\", not \"{}\"", start));
  for (Vector3& p : particles.position) p = centre + keep.cwiseProduct(p - centre);
}

} // namespace

Vector3 centre_of_mass(const std::vector<Vector3>& position, const std::vector<double>& mass) {
  Vector3 moment = Vector3::Zero();
  double total = 0;
  for (std::size_t i = 0; i < position.size(); ++i) {
    moment += mass[i] * (position[i] - position[0]); // relative to a particle: exact far from the origin
    total += mass[i];
  }
  return total > 0 ? Vector3(position[0] + moment / total) : Vector3(Vector3::Zero());
}

void set_initial_state(const Body& body, const std::vector<DeformedPart>& parts, BodyParticles& particles) {
  if (particles.position.empty()) return;
  const Vector3 centre_at_rest = centre_of_mass(particles.position, particles.mass);
  for (const DeformedPart& part : parts) deform_part(part, particles);
  if (!body.deform.isIdentity(0) || !body.start.empty()) {
    for (Vector3& p : particles.position) p = centre_at_rest + body.deform * (p - centre_at_rest);
    start_from(body.start, centre_at_rest, particles);
  }
  const Vector3 centre = centre_of_mass(particles.position, particles.mass);
  particles.velocity.resize(particles.position.size());
  for (std::size_t i = 0; i < particles.position.size(); ++i)
    particles.velocity[i] = body.velocity + body.spin.cross(particles.position[i] - centre);
}

} // namespace pliant
