// Camera and sun as the shaders want them.
#include "backends/gl/render/frame.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace pliant::gl {

namespace {

FrameBlock::Vector4 pack(const Vector3& v, double w) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
          static_cast<float>(w)};
}

std::array<float, 16> pack(const Eigen::Matrix4d& m) {
  std::array<float, 16> packed{};
  for (int i = 0; i < 16; ++i) packed[i] = static_cast<float>(m.data()[i]);
  return packed;
}

/// 1, 2 or 5 times a power of ten, not above `value`.
double round_down(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  const double lead = value / power;
  return power * (lead >= 5 ? 5 : lead >= 2 ? 2 : 1);
}

} // namespace

void fill_view(FrameBlock& block, const Stage& stage, unsigned width, unsigned height,
               const Eigen::Vector2d& jitter) {
  const View& view = stage.view;
  const Eigen::Vector2d device(2 * jitter.x() / width, 2 * jitter.y() / height);
  const Vector3 right = view.right * view.tangent * view.aspect, up = view.up * view.tangent;
  const double size = stage.subject.radius();
  block.world_to_clip = pack(view.world_to_clip(device));
  block.eye = pack(view.eye, view.near);
  block.axis = pack(view.forward, 0);
  block.forward = pack(Vector3(view.forward - device.x() * right - device.y() * up), 0);
  block.ray_right = pack(right, 0.5 * height / view.tangent);
  block.ray_up = pack(up, 0);
  block.up = pack(stage.up, round_down(0.45 * size));
  block.picture = {static_cast<float>(width), static_cast<float>(height), 1.0f / static_cast<float>(width),
                   1.0f / static_cast<float>(height)};
  block.sizes[1] = static_cast<float>(0.16 * size);
  block.sizes[2] = static_cast<float>(14 * size);
}

void fill_shadow(FrameBlock& block, const Stage& stage, const Box& casters, unsigned map) {
  // What flies out of the picture casts no shadow into it, and must not coarsen the map.
  const Vector3 centre = stage.subject.centre();
  const double limit = 4 * std::max(stage.subject.radius(), 1e-9);
  Box box = casters;
  box.low = box.low.cwiseMax(centre - Vector3::Constant(limit));
  box.high = box.high.cwiseMin(centre + Vector3::Constant(limit));
  if (box.empty()) box = stage.subject;

  const Vector3 z = -stage.to_sun;
  const Vector3 x =
      (std::abs(z.dot(stage.up)) < 0.99 ? Vector3(stage.up.cross(z)) : z.unitOrthogonal()).normalized();
  const Vector3 y = z.cross(x);
  Vector3 low = Vector3::Constant(1e300), high = -low;
  for (int i = 0; i < 8; ++i) {
    const Vector3 corner = box.corner(i), at(x.dot(corner), y.dot(corner), z.dot(corner));
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const Vector3 size = high - low;
  const double step = std::log(1.08);
  const double across =
      std::exp(step * std::ceil(std::log(1.06 * std::max({size.x(), size.y(), 1e-9})) / step));
  const double texel = across / map;
  const double left = std::floor((0.5 * (low.x() + high.x()) - 0.5 * across) / texel) * texel;
  const double bottom = std::floor((0.5 * (low.y() + high.y()) - 0.5 * across) / texel) * texel;
  const double range = 1.06 * std::max(size.z(), 1e-9), first = 0.5 * (low.z() + high.z() - range);

  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.row(0) << x.transpose() / across, -left / across;
  matrix.row(1) << y.transpose() / across, -bottom / across;
  matrix.row(2) << z.transpose() / range, -first / range;
  block.world_to_shadow = pack(matrix);
  block.to_sun = pack(stage.to_sun, 0.045);
  block.sun_right = pack(x, across);
  block.sun_up = pack(y, range);
  block.casters = pack(box.centre(), std::max(box.radius(), 1e-9));
}

} // namespace pliant::gl
