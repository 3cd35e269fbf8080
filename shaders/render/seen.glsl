// What a sample of the picture shows.
layout(binding = 4) uniform sampler2DMS colour_samples; // square roots
layout(binding = 5) uniform sampler2DMS normal_samples; // w: kind
layout(binding = 6) uniform sampler2DMS depth_samples;

#include "render/planes.glsl"

// m along the view axis. A plane is met exactly: its depth may be anything up to infinity.
float seen_depth(vec4 normal, float depth, vec3 ray) {
  if (normal.w < kind_plane) return depth_from(depth);
  vec4 plane = planes[int(normal.w - kind_plane + 0.5)];
  float slope = dot(plane.xyz, ray);
  return slope < -1e-6 ? min((plane.w - dot(plane.xyz, eye.xyz)) / slope, 1e7) : 1e7;
}
