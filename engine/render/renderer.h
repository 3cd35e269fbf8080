// Pictures of a simulation, drawn by OpenGL without a display. Implemented in backends/gl/render.
//
// The renderer shares the GL context of the simulation's device and draws from its buffers; where the
// simulation runs on the CPU it makes a context of its own and copies positions over, once a frame.
#pragma once

#include "engine/device/device.h"
#include "engine/model/model.h"
#include "engine/render/image.h"

#include <memory>
#include <string>

namespace pliant {

/// What changes from frame to frame. Buffers belong to the simulation's device; world coordinates, m.
struct RenderState {
  const BufferStorage* particle = nullptr; ///< real4 a particle: world position; w: field value
  const BufferStorage* vertex =
      nullptr;     ///< real4 a vertex of all carried meshes, body after body: position; w: field
  double time = 0; ///< s
  const BufferStorage* torn =
      nullptr; ///< uint a triangle of all carried meshes, body after body: 1 where it is not drawn
};

class Renderer {
public:
  virtual ~Renderer() = default;
  /// A picture of scene.render.size, 3 channels. Bodies whose mesh is not drawn, and all where `vertex` is
  /// null, are drawn as spheres. The same state gives the same picture, except that a field's range, where
  /// the scene gives none, is the widest drawn so far.
  virtual Image draw(Device& simulation, const RenderState& state) = 0;
};

/// The boundaries' motions are evaluated at RenderState::time. `field_label` names the field and its unit for
/// the legend when scene.render.color is not "body". The device must outlive the renderer. Throws
/// Error(no_device) naming the package to install; Error(usage) for a picture larger than the device can
/// draw; Error(too_large) for more particles than it can draw.
std::unique_ptr<Renderer> make_renderer(Device& simulation, const Scene& scene, const Model& model,
                                        const std::string& field_label = "");

} // namespace pliant
