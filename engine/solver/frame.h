// What a frame shows: particles and carried meshes in world coordinates, made on the device when a frame is
// due.
#pragma once

#include "engine/model/skin.h"
#include "engine/solver/simulation.h"

namespace pliant {

struct FrameNeeds {
  bool surfaces = false, strain = false;
  std::vector<BufferSpec> buffers; ///< component: "frames", "surfaces" or "strain"
  std::vector<KernelSpec> kernels;
};
FrameNeeds frame_needs(const Scene& scene, const Model& model, const PlanRequest& request);

class FrameOutput {
public:
  explicit FrameOutput(Simulation& simulation);

  /// Fills the buffers below from the simulation's state.
  void update();
  const BufferStorage* particle() const { return particle_; } ///< real4: world position, m; w: field
  const BufferStorage* vertex() const { return vertex_; }     ///< the same for carried meshes; null without
  const Skin& skin() const { return skin_; }
  /// uint a triangle of all carried meshes, body after body: 1 where its particles have lost each other; null
  /// where nothing breaks.
  const BufferStorage* torn() const { return torn_; }
  const std::vector<std::uint32_t>& first_triangle() const { return triangles_.first; } ///< as skin().first

  /// Whether each particle is there; empty where all are.
  std::vector<bool> present();
  /// A field of every particle, `components` values each. Throws Error(usage) for one that the plan lacks.
  std::vector<float> field(const std::string& name, unsigned& components);

private:
  void find_torn();

  Simulation& simulation_;
  Skin skin_;
  Buffer particle_, vertex_, gradient_, start_, reference_;
  Buffer skin_particle_, skin_weight_, skin_reference_;
  SkinTriangles triangles_;
  Buffer skin_triangle_, torn_;
  std::uint32_t colour_ = 0;
};

/// Label with unit for legends and axes, e.g. "speed (m/s)".
std::string field_label(const std::string& field);

} // namespace pliant
