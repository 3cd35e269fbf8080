// The uniform block of shaders/render/frame.glsl, as the CPU fills it.
#pragma once

#include "backends/gl/render/camera.h"

#include <Eigen/Core>

#include <array>

namespace pliant::gl {

/// Same order as frame.glsl, which says what each is.
struct FrameBlock {
  using Vector4 = std::array<float, 4>;
  std::array<float, 16> world_to_clip{}, world_to_shadow{};
  Vector4 eye{}, axis{}, forward{}, ray_right{}, ray_up{}, to_sun{}, sun_right{}, sun_up{}, up{}, casters{},
      picture{}, sizes{}, field{};
};
static_assert(sizeof(FrameBlock) == 2 * 64 + 13 * 16);

/// The number of planes that shaders/render/planes.glsl holds.
inline constexpr std::size_t max_planes = 16;

/// The parts that depend on the view; `jitter` in pixels.
void fill_view(FrameBlock& block, const Stage& stage, unsigned width, unsigned height,
               const Eigen::Vector2d& jitter);

/// The shadow map around all that casts one (`casters`, m, world), `map` texels wide. Its size follows the
/// casters in steps and its middle whole texels, so that still shadows do not shimmer while something moves.
void fill_shadow(FrameBlock& block, const Stage& stage, const Box& casters, unsigned map);

} // namespace pliant::gl
