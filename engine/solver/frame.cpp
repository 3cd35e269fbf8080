// What a frame shows; see frame.h.
#include "engine/solver/frame.h"

#include "engine/core/error.h"
#include "engine/model/failure.h"
#include "engine/solver/elasticity.h"
#include "engine/solver/state.h"
#include "kernels/deformation.h"
#include "kernels/frame_particles.h"
#include "kernels/skin.h"
#include "kernels/surface_tear.h"

#include <algorithm>
#include <array>

namespace pliant {

namespace {

struct Colour {
  const char* name;
  const char* label;
  std::uint32_t option; ///< of the kernel frame_particles
};
constexpr std::array colours{Colour{"body", "", 0},
                             Colour{"velocity", "speed (m/s)", 1},
                             Colour{"strain", "equivalent strain", 2},
                             Colour{"energy", "energy density (J/m3)", 3},
                             Colour{"displacement", "displacement (m)", 4},
                             Colour{"damage", "damage", 5},
                             Colour{"plastic_strain", "plastic strain", 6}};

std::uint32_t colour_option(const Scene& scene) {
  for (const Colour& colour : colours)
    if (scene.render.color == colour.name) return colour.option;
  return 0;
}

bool contains(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Some are yet to be born, or were taken out.
bool may_lack_particles(const Scene& scene) {
  return !scene.emitters.empty() || !scene.sinks.empty();
}

} // namespace

std::string field_label(const std::string& field) {
  for (const Colour& colour : colours)
    if (field == colour.name) return colour.label;
  return field;
}

FrameNeeds frame_needs(const Scene& scene, const Model& model, const PlanRequest& request) {
  FrameNeeds needs;
  if (!request.frames) return needs;
  const std::size_t n = model.count();
  std::size_t vertices = 0, triangles = 0;
  for (const BodyModel& body : model.bodies)
    if (body.surface) {
      vertices += body.surface_reference.size();
      triangles += body.surface->triangles.size();
    }
  needs.surfaces = request.surfaces && vertices > 0;
  needs.strain = needs.surfaces || scene.render.color == "strain" || contains(request.fields, "strain");
  const bool start = scene.render.color == "displacement" || scene.render.color == "energy";
  needs.buffers.push_back({"particle", Type::real4, n, "frames"});
  if (start) needs.buffers.push_back({"start", Type::real4, n, "frames"});
  if (scene.flows() && scene.render.color == "plastic_strain") // bonded fluids keep theirs in sorted order
    needs.buffers.push_back({"flow", Type::real4, 2 * n, "frames"});
  needs.kernels.push_back(kernel_variant(
      kernels::frame_particles::Args{.field = colour_option(scene), .gone = may_lack_particles(scene)},
      "frames"));
  if (needs.strain) {
    needs.buffers.push_back({"gradient", Type::real4, 3 * n, "strain"});
    needs.kernels.push_back({&kernels::deformation::Args::info(), "strain"});
  }
  if (needs.surfaces) {
    needs.buffers.push_back({"vertex", Type::real4, vertices, "surfaces"});
    needs.buffers.push_back({"skin_particle", Type::uint4, vertices, "surfaces"});
    needs.buffers.push_back({"skin_weight", Type::real4, vertices, "surfaces"});
    needs.buffers.push_back({"skin_reference", Type::real4, vertices, "surfaces"});
    needs.buffers.push_back({"reference", Type::real4, n, "surfaces"});
    needs.kernels.push_back({&kernels::skin::Args::info(), "surfaces"});
    if (triangles > 0 && can_break(scene, model)) {
      needs.buffers.push_back({"skin_triangle", Type::uint4, triangles, "surfaces"});
      needs.buffers.push_back({"torn", Type::uint, triangles, "surfaces"});
      needs.kernels.push_back({&kernels::surface_tear::Args::info(), "surfaces"});
    }
  }
  return needs;
}

FrameOutput::FrameOutput(Simulation& simulation) : simulation_(simulation) {
  const Plan& plan = simulation.plan_;
  Device& device = simulation.device_;
  const Model& model = simulation.model_;
  const std::pair<const char*, Buffer*> members[] = {
      {"particle", &particle_},           {"vertex", &vertex_},
      {"gradient", &gradient_},           {"start", &start_},
      {"reference", &reference_},         {"skin_particle", &skin_particle_},
      {"skin_weight", &skin_weight_},     {"skin_reference", &skin_reference_},
      {"skin_triangle", &skin_triangle_}, {"torn", &torn_}};
  for (const auto& [name, buffer] : members)
    if (const BufferSpec* spec = plan.find(name))
      *buffer = device.allocate(spec->name, spec->type, spec->count);
  colour_ = colour_option(simulation.scene_);
  if (start_) {
    std::vector<Real4<double>> rows;
    for (std::size_t i = 0; i < model.count(); ++i)
      rows.push_back({model.position[i].x(), model.position[i].y(), model.position[i].z(), model.volume[i]});
    device.upload(start_, rows);
  }
  if (!plan.surfaces) return;
  skin_ = make_skin(model);
  device.write(skin_particle_, 0, std::as_bytes(std::span(skin_.particle)));
  device.upload(skin_weight_, skin_.weight);
  device.upload(skin_reference_, skin_.reference);
  std::vector<Real4<double>> rows;
  for (const Vector3& x : model.reference) rows.push_back({x.x(), x.y(), x.z(), 0});
  device.upload(reference_, rows);
  if (!torn_) return;
  triangles_ = make_skin_triangles(model, skin_);
  device.write(skin_triangle_, 0, std::as_bytes(std::span(triangles_.triangle)));
}

void FrameOutput::update() {
  SimulationState& s = *simulation_.state_;
  Device& device = simulation_.device_;
  device.enter("frames");
  if (gradient_)
    for (const LawRange& range : simulation_.model_.laws)
      device.run(kernels::deformation::Args{.threads = range.count,
                                            .first = range.first,
                                            .first_slice = range.first_slice,
                                            .unit = simulation_.elasticity_->unit(),
                                            .slice_begin = s.slice_begin,
                                            .bond = s.bond,
                                            .weight = s.weight,
                                            .position = s.position,
                                            .gradient = gradient_});
  const Vector3& origin = simulation_.scene_origin_;
  if (simulation_.plan_.fluid && s.flow) {
    std::vector<Real4<double>> rows(s.flow.count(), {0, 0, 0, 0});
    const std::vector<double> strain = simulation_.plastic_strain();
    for (std::size_t i = 0; i < strain.size(); ++i) rows[2 * i].x = strain[i];
    device.upload(s.flow, rows);
  }
  device.run(kernels::frame_particles::Args{
      .threads = static_cast<std::uint32_t>(simulation_.plan_.particles),
      .field = colour_,
      .gone = simulation_.plan_.fluid_sources,
      .share_at = simulation_.plan_.share_row * static_cast<std::uint32_t>(simulation_.plan_.particles),
      .scene_x = origin.x(),
      .scene_y = origin.y(),
      .scene_z = origin.z(),
      .owner = s.owner,
      .origin = s.origin,
      .position = s.position,
      .velocity = s.velocity,
      .gradient = gradient_,
      .energy = s.energy,
      .shape = s.shape,
      .flow = s.flow,
      .start = start_,
      .particle = particle_});
  if (vertex_)
    device.run(kernels::skin::Args{.threads = static_cast<std::uint32_t>(vertex_.count()),
                                   .skin_particle = skin_particle_,
                                   .skin_weight = skin_weight_,
                                   .skin_reference = skin_reference_,
                                   .reference = reference_,
                                   .gradient = gradient_,
                                   .particle = particle_,
                                   .vertex = vertex_});
  if (torn_) find_torn();
  device.enter("");
}

void FrameOutput::find_torn() {
  const SimulationState& s = *simulation_.state_;
  const Model& model = simulation_.model_;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const std::uint32_t count = triangles_.first[b + 1] - triangles_.first[b];
    if (count == 0) continue;
    for (const LawRange& range : model.laws) { // the one that its body lies in
      if (model.bodies[b].first < range.first || model.bodies[b].first >= range.first + range.count) continue;
      simulation_.device_.run(kernels::surface_tear::Args{.threads = count,
                                                          .first_triangle = triangles_.first[b],
                                                          .first = range.first,
                                                          .first_slice = range.first_slice,
                                                          .slice_begin = s.slice_begin,
                                                          .bond = s.bond,
                                                          .skin_particle = skin_particle_,
                                                          .skin_triangle = skin_triangle_,
                                                          .torn = torn_});
    }
  }
}

std::vector<bool> FrameOutput::present() {
  std::vector<bool> there;
  if (!simulation_.plan_.fluid_sources) return there;
  for (const Real4<double>& y : simulation_.device_.download_real4(simulation_.state_->position))
    there.push_back(y.w != 0);
  return there;
}

std::vector<float> FrameOutput::field(const std::string& name, unsigned& components) {
  Device& device = simulation_.device_;
  const Model& model = simulation_.model_;
  std::vector<float> values;
  components = 1;
  if (name == "velocity" || name == "displacement") {
    components = 3;
    const bool velocity = name == "velocity";
    const std::vector<Vector3> vectors = velocity ? simulation_.velocities() : simulation_.positions();
    for (std::size_t i = 0; i < vectors.size(); ++i) {
      const Vector3 v = velocity ? vectors[i] : Vector3(vectors[i] - model.position[i]);
      for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(v[c]));
    }
    return values;
  }
  if (name == "strain" && gradient_) {
    const std::vector<Real4<double>> rows = device.download_real4(gradient_);
    for (std::size_t i = 0; i < rows.size(); i += 3) values.push_back(static_cast<float>(rows[i].w));
    return values;
  }
  if (name == "energy" && simulation_.plan_.energy) {
    const std::vector<double> energy = device.download_real(simulation_.state_->energy);
    for (std::size_t i = 0; i < energy.size(); ++i)
      values.push_back(static_cast<float>(energy[i] / model.volume[i]));
    return values;
  }
  if (name == "damage" && simulation_.plan_.failure) {
    for (const double damage : simulation_.damage()) values.push_back(static_cast<float>(damage));
    return values;
  }
  if (name == "plastic_strain" && (simulation_.plan_.plastic || simulation_.plan_.fluid_flow)) {
    for (const double strain : simulation_.plastic_strain()) values.push_back(static_cast<float>(strain));
    return values;
  }
  throw Error(ExitCode::usage,
              "field '" + name + "' is not in this scene's plan: name it in [output] fields");
}

} // namespace pliant
