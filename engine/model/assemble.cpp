// A scene's bodies as particles: sampled, bonded, given materials, conditions and an initial state.
#include "engine/core/error.h"
#include "engine/core/memory.h"
#include "engine/model/anisotropy.h"
#include "engine/model/arrange.h"
#include "engine/model/checks.h"
#include "engine/model/emission.h"
#include "engine/model/failure.h"
#include "engine/model/initial_state.h"
#include "engine/model/shape_tensor.h"
#include "engine/scene/mesh_refine.h"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace pliant {

namespace {

/// Searching for a spacing that would do stops at bodies of this many particles.
constexpr double largest_trial = 3e5;

const char* kind_name(Condition::Kind kind) {
  switch (kind) {
  case Condition::Kind::fixed:
    return "fixed";
  case Condition::Kind::moved:
    return "moved";
  case Condition::Kind::loaded:
    return "loaded";
  }
  return "unknown";
}

/// At the peak of assembling and running; measured at 450,000 particles on the CPU: 2.6 kB a particle.
constexpr double bytes_a_bond = 100;
/// Spacings; edges of the surface of a body that breaks are no longer, so that it can tear between particles.
constexpr double largest_torn = 1.5;

/// Runs `work`; what it throws gets the place in front.
template <class Work> auto located(const std::string& place, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", place, error.what()));
  }
}

std::uint32_t material_index(const Scene& scene, const std::string& name, const std::string& place) {
  for (std::size_t m = 0; m < scene.materials.size(); ++m)
    if (scene.materials[m].name == name) return static_cast<std::uint32_t>(m);
  throw Error(ExitCode::usage, fmt::format("{}: there is no material '{}'", place, name));
}

void add_constants(const Scene& scene, std::uint32_t material, Neighbourhood neighbourhood, Model& model) {
  const Material& m = scene.materials[material];
  located(fmt::format("{}: material '{}'", scene.file.string(), m.name), [&] {
    if (!(m.density > 0) || !std::isfinite(m.density))
      throw Error(ExitCode::usage, fmt::format("the density must be positive, not {} kg/m3", m.density));
    model.constants.push_back(law_constants(m, neighbourhood));
    model.stretch.push_back(stretch_energy(m, neighbourhood));
  });
}

/// Builds one body of the scene and appends it to the model.
class BodyBuilder {
public:
  BodyBuilder(const Scene& scene, std::uint32_t index, Model& model)
      : scene_(scene), body_(scene.bodies[index]), index_(index), model_(model),
        place_(place_of(scene, index)) {
    base_material_ = material_index(scene, body_.material, place_);
    law_ = law_of(scene.materials[base_material_]);
    for (const MaterialRegion& region : body_.regions) {
      const Law other = law_of(scene.materials[material_index(scene, region.material, place_)]);
      if (other != law_)
        throw Error(
            ExitCode::usage,
            fmt::format("{}: material '{}' has law {} and '{}' has law {}; a body's materials must share one",
                        place_, body_.material, law_name(law_), region.material, law_name(other)));
    }
  }

  Law law() const { return law_; }
  /// In three dimensions; a particle of it stands for spacing^2 times its thickness.
  bool sheet() const {
    return scene_.simulation.dimension == 3 &&
           (body_.thickness.has_value() || body_.shape.kind == Shape::Kind::sheet);
  }

  void build() {
    const Sampling sampling = located(place_, [&] { return sample_body(scene_.simulation.spacing); });
    for (const std::string& warning : sampling.warnings) model_.warnings.push_back(place_ + ": " + warning);
    check_memory(sampling);
    if (law_ == Law::fluid) {
      pour(sampling);
      return;
    }
    place(sampling);
    check_sparse(sampling);
    set_materials(sampling);
    const WeightReport report = located(place_, [&] {
      return compute_weights(particles_.arrangement.bonds, particles_.arrangement.reference, model_.spacing,
                             law_, scene_.simulation.weights, influence_of(scene_.simulation, horizon()),
                             flat() ? 2 : 3);
    });
    merge(model_.weight_report, report, model_.count(), particles_.position.size());
    apply_conditions();
    located(place_, [&] { set_initial_state(body_, deformed_parts(), particles_); });
    describe(sampling);
    located(place_, [&] { append(model_, index_, law_, std::move(particles_)); });
  }

private:
  static std::string place_of(const Scene& scene, std::uint32_t index) {
    const Body& body = scene.bodies[index];
    return fmt::format("{}{}: body '{}'", scene.file.string(), body.typed_at, body.name);
  }

  std::filesystem::path folder() const { return scene_.file.parent_path(); }
  double horizon() const { return body_.horizon.value_or(scene_.simulation.horizon); } ///< spacings
  bool flat() const { return scene_.simulation.dimension == 2 || sheet(); }
  double thickness() const { return flat() ? body_.thickness.value_or(sheet() ? 0 : 1) : 0; }

  Sampling sample_body(double spacing) const {
    if (scene_.simulation.dimension == 2) return sample_section(body_.shape, thickness(), spacing, folder());
    return sheet() ? sample_sheet(body_.shape, thickness(), spacing, folder())
                   : sample(body_.shape, spacing, folder());
  }

  void place(const Sampling& sampling) {
    std::vector<std::size_t> severed(body_.cuts.size(), 0);
    Severed cut;
    if (!body_.cuts.empty())
      cut = [&](const Vector3& from, const Vector3& to) {
        const Vector3 a = sampling.origin + sampling.axes * from, b = sampling.origin + sampling.axes * to;
        for (std::size_t c = 0; c < body_.cuts.size(); ++c)
          if (box_meets(body_.cuts[c].region, a, b)) return ++severed[c] > 0;
        return false;
      };
    particles_.arrangement = located(
        place_, [&] { return arrange(sampling.reference, model_.spacing, horizon() * model_.spacing, cut); });
    for (std::size_t c = 0; c < severed.size(); ++c)
      if (severed[c] == 0)
        throw Error(ExitCode::usage,
                    fmt::format("{}: cut {} severs no bond; put its box between particles of the body",
                                place_, c + 1));
    particles_.position.reserve(sampling.reference.size());
    for (const Vector3& r : particles_.arrangement.reference)
      particles_.position.push_back(sampling.origin + sampling.axes * r);
    for (const Vector3& p : particles_.position) box_.extend(p);
  }

  /// Particles without bonds. Each has the mass of its share of a full lattice, so that they are at rest
  /// where they are.
  void pour(const Sampling& sampling) {
    Arrangement& body = particles_.arrangement;
    body = located(place_, [&] { return arrange_unbonded(sampling.reference, model_.spacing); });
    for (const Vector3& r : body.reference)
      particles_.position.push_back(sampling.origin + sampling.axes * r);
    for (const Vector3& p : particles_.position) box_.extend(p);
    set_materials(sampling);
    const double volume = std::pow(model_.spacing, 2) * (flat() ? thickness() : model_.spacing);
    for (std::size_t i = 0; i < particles_.position.size(); ++i) {
      particles_.volume[i] = volume;
      particles_.mass[i] = scene_.materials[particles_.material[i]].density * volume;
    }
    located(place_, [&] { set_initial_state(body_, {}, particles_); });
    describe(sampling);
    model_.bodies[index_].surface.reset(); // nothing holds a mesh to particles that part
    model_.bodies[index_].surface_reference.clear();
    located(place_, [&] { append(model_, index_, law_, std::move(particles_)); });
  }

  /// Of the bodies so far and this one, to assemble and to run them.
  void check_memory(const Sampling& sampling) const {
    const double particles = static_cast<double>(model_.count() + sampling.reference.size());
    const double neighbours = flat() ? std::numbers::pi * std::pow(horizon(), 2)
                                     : 4.0 / 3 * std::numbers::pi * std::pow(horizon(), 3);
    located(place_, [&] {
      require_memory(
          fmt::format("with this body the scene has {:.3g} particles of about {:.0f} neighbours and needs",
                      particles, neighbours),
          particles * neighbours * bytes_a_bond, available_memory(), model_.spacing);
    });
  }

  void check_sparse(const Sampling& sampling) {
    const std::optional<std::string> found = sparseness(particles_.arrangement.bonds, flat());
    if (!found) return;
    if (scene_.allow_sparse) {
      model_.warnings.push_back(fmt::format("{} {}", place_, *found));
      return;
    }
    throw Error(ExitCode::usage,
                fmt::format("{} {} at a spacing of {:.4g} m and a horizon of {:.4g} spacings; {}, or "
                            "allow \"sparse\"",
                            place_, *found, model_.spacing, horizon(), advise_spacing(sampling.volume)));
  }

  /// Tries smaller spacings on the body itself, since what is thin is not known beforehand.
  std::string advise_spacing(double volume) const {
    double spacing = model_.spacing;
    while (true) {
      spacing *= 0.75;
      const double scale = std::pow(10, std::floor(std::log10(spacing)) - 1);
      const double rounded = std::floor(spacing / scale) * scale; // two digits, downwards
      if (volume / (rounded * rounded * (flat() ? thickness() : rounded)) > largest_trial)
        return fmt::format("no spacing down to {:.2g} m would do either: the shape is too thin", rounded);
      const Sampling trial = sample_body(rounded);
      const Arrangement body = arrange(trial.reference, rounded, horizon() * rounded);
      if (!sparseness(body.bonds, flat())) return fmt::format("a spacing of {:.2g} m would do", rounded);
    }
  }

  /// The body's particles in a region, by rest position. Throws Error(usage) where there are none.
  std::vector<std::uint32_t> select(const Shape& region, const std::string& what) const {
    const ShapeQuery query = located(place_ + ": " + what, [&] { return ShapeQuery(region, folder()); });
    const std::size_t count = particles_.position.size();
    std::vector<std::uint8_t> inside(count);
#pragma omp parallel for schedule(dynamic, 256)
    for (std::size_t i = 0; i < count; ++i) inside[i] = query.contains(particles_.position[i]);
    std::vector<std::uint32_t> selected;
    for (std::uint32_t i = 0; i < count; ++i)
      if (inside[i]) selected.push_back(i);
    if (selected.empty())
      throw Error(
          ExitCode::usage,
          fmt::format("{}: {} selects no particle; the body's particles lie between ({:.4g}, {:.4g}, {:.4g}) "
                      "and ({:.4g}, {:.4g}, {:.4g}) m",
                      place_, what, box_.min().x(), box_.min().y(), box_.min().z(), box_.max().x(),
                      box_.max().y(), box_.max().z()));
    return selected;
  }

  void set_materials(const Sampling& sampling) {
    const std::size_t count = particles_.position.size();
    particles_.material.assign(count, base_material_);
    for (std::size_t r = 0; r < body_.regions.size(); ++r) {
      const std::string what = fmt::format("region {} (material '{}')", r + 1, body_.regions[r].material);
      const std::uint32_t material = material_index(scene_, body_.regions[r].material, place_);
      for (const std::uint32_t i : select(body_.regions[r].region, what)) particles_.material[i] = material;
    }
    particles_.volume.assign(count, sampling.volume / static_cast<double>(count));
    particles_.mass.resize(count);
    for (std::size_t i = 0; i < count; ++i)
      particles_.mass[i] = scene_.materials[particles_.material[i]].density * particles_.volume[i];
    if (!sheet()) return;
    for (std::uint32_t& material : particles_.material) material = of_sheets(material);
  }

  /// The same material calibrated for sheets.
  std::uint32_t of_sheets(std::uint32_t typed) {
    std::vector<std::uint32_t>& known = model_.sheet_material;
    const auto found = std::find(known.begin(), known.end(), typed);
    const auto index =
        static_cast<std::uint32_t>(scene_.materials.size() + std::size_t(found - known.begin()));
    if (found != known.end()) return index;
    known.push_back(typed);
    add_constants(scene_, typed, Neighbourhood::plane_stress, model_);
    return index;
  }

  void apply_conditions() {
    constexpr std::uint32_t free = UINT32_MAX;
    const auto first = static_cast<std::uint32_t>(model_.count());
    std::vector<std::uint32_t> motion(particles_.position.size(), free);
    for (std::size_t c = 0; c < body_.conditions.size(); ++c) {
      const Condition& condition = body_.conditions[c];
      const std::string what = fmt::format("condition {} ({})", c + 1, kind_name(condition.kind));
      const std::vector<std::uint32_t> selected = select(condition.region, what);
      if (condition.kind == Condition::Kind::loaded) {
        double mass = 0;
        for (const std::uint32_t i : selected) mass += particles_.mass[i];
        for (const std::uint32_t i : selected)
          model_.loads.push_back(
              {first + i, condition.force * (particles_.mass[i] / mass), condition.start, condition.end});
        continue;
      }
      std::size_t taken = 0;
      for (const std::uint32_t i : selected) {
        taken += motion[i] != free;
        motion[i] = static_cast<std::uint32_t>(model_.motions.size());
      }
      if (taken > 0)
        model_.warnings.push_back(
            fmt::format("{}: {} takes {} particles from an earlier condition; the later one "
                        "holds them",
                        place_, what, taken));
      model_.motions.push_back(condition.kind == Condition::Kind::moved ? condition.motion : Motion{});
    }
    for (std::uint32_t i = 0; i < motion.size(); ++i)
      if (motion[i] != free) model_.held.push_back({first + i, motion[i]});
  }

  std::vector<DeformedPart> deformed_parts() const {
    std::vector<DeformedPart> parts;
    for (const DeformedRegion& one : body_.deformed)
      parts.push_back({select(one.region, fmt::format("deformed region {}", parts.size() + 1)), &one});
    return parts;
  }

  bool breaks() const {
    return scene_.materials[base_material_].breaks() ||
           std::any_of(body_.regions.begin(), body_.regions.end(), [&](const MaterialRegion& region) {
             return scene_.material(region.material)->breaks();
           });
  }

  void describe(const Sampling& sampling) {
    BodyModel& described = model_.bodies[index_];
    described.name = body_.name;
    described.origin = sampling.origin;
    described.axes = sampling.axes;
    described.color = body_.color.value_or(scene_.materials[base_material_].color);
    described.self_contact = body_.self_contact;
    described.thickness = thickness();
    described.surface = sampling.surface;
    if (!sampling.surface) return;
    if (breaks()) described.surface = refine(std::move(*described.surface), largest_torn * model_.spacing);
    described.surface_reference.reserve(described.surface->vertices.size());
    for (const Vector3& v : described.surface->vertices)
      described.surface_reference.push_back(sampling.axes.transpose() * (v - sampling.origin));
  }

  const Scene& scene_;
  const Body& body_;
  std::uint32_t index_;
  Model& model_;
  std::string place_; ///< how errors name the body
  std::uint32_t base_material_ = 0;
  Law law_ = Law::corotated;
  BodyParticles particles_;
  Eigen::AlignedBox3d box_; ///< of the rest positions
};

/// What a calibration that is not exact really gives.
void warn_of_calibration(const Scene& scene, Model& model) {
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    const Material& material = scene.materials[m];
    const auto index = static_cast<std::uint32_t>(m);
    if (material.calibration == "exact" ||
        std::find(model.material.begin(), model.material.end(), index) == model.material.end())
      continue;
    const SmallStrain real = small_strain(material);
    model.warnings.push_back(fmt::format("material '{}': calibration \"{}\" gives a Young's modulus of "
                                         "{:.6g} Pa and a Poisson's ratio of {:.4f}, not "
                                         "the {:.6g} Pa and {:.4f} typed; \"exact\" gives these",
                                         material.name, material.calibration, real.young, real.poisson,
                                         material.young, material.poisson));
  }
}

/// Of the materials as the scene numbers them. One that only sheets have may have a ratio that no solid could
/// have.
void set_constants(const Scene& scene, const std::vector<BodyBuilder>& builders, Model& model) {
  model.dimension = scene.simulation.dimension;
  const Neighbourhood usual = model.dimension == 3                 ? Neighbourhood::solid
                              : scene.simulation.plane == "stress" ? Neighbourhood::plane_stress
                                                                   : Neighbourhood::plane_strain;
  for (std::uint32_t m = 0; m < scene.materials.size(); ++m) {
    bool of_solids = false, of_sheets = false;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const Body& body = scene.bodies[b];
      const auto is = [&](const std::string& name) { return name == scene.materials[m].name; };
      if (is(body.material) || std::any_of(body.regions.begin(), body.regions.end(),
                                           [&](const MaterialRegion& region) { return is(region.material); }))
        (builders[b].sheet() ? of_sheets : of_solids) = true;
    }
    add_constants(scene, m, of_sheets && !of_solids ? Neighbourhood::plane_stress : usual, model);
  }
}

/// Turns ids that count from 0 in each body into ids that count through the scene.
void number_through(Model& model) {
  std::uint32_t next = 0;
  for (const BodyModel& body : model.bodies) {
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) model.id[i] += next;
    next += body.count;
  }
}

} // namespace

Model assemble(const Scene& scene) {
  Model model;
  model.spacing = scene.simulation.spacing;
  model.horizon = scene.simulation.horizon * scene.simulation.spacing;
  model.bonds.begin.push_back(0);
  model.bodies.resize(scene.bodies.size());
  std::vector<BodyBuilder> builders;
  builders.reserve(scene.bodies.size());
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) builders.emplace_back(scene, b, model);
  set_constants(scene, builders, model);
  std::vector<std::uint32_t> order(scene.bodies.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return builders[a].law() < builders[b].law(); });
  for (const std::uint32_t b : order) builders[b].build();
  number_through(model);
  require_solid(scene, model);
  model.bonds.strength = located(scene.file.string(), [&] { return bond_strengths(scene, model); });
  warn_of_calibration(scene, model);
  if (const std::optional<Overlap> found = overlap(model)) {
    const std::string text =
        fmt::format("{}{}: {}", scene.file.string(), scene.bodies[found->body].typed_at, found->text);
    if (!scene.allow_overlap) throw Error(ExitCode::usage, text + "; move them apart, or allow \"overlap\"");
    model.warnings.push_back(text);
  }
  add_emitters(scene, model);
  return model;
}

} // namespace pliant
