// Gathers four pixels in a row or column that lie on the same surface.
uniform ivec2 direction;
layout(binding = 9) uniform sampler2D rough;
layout(location = 0) out vec4 visible;

#include "render/frame.glsl"
#include "render/seen.glsl"

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), last = ivec2(picture.xy) - 1;
  visible = texelFetch(rough, at, 0);
  vec4 normal = texelFetch(normal_samples, at, 0);
  if (normal.w == kind_sky) return;
  vec3 ray = ray_through(first_sample(gl_FragCoord.xy));
  float facing = dot(normal.xyz, ray), own = visible.z;
  vec3 sum = vec3(visible.xy, 1.0) * 1e-3;
  for (int i = -2; i < 2; ++i) {
    ivec2 other = clamp(at + i * direction, ivec2(0), last);
    vec4 found = texelFetch(rough, other, 0);
    float slope = dot(normal.xyz, ray_through(first_sample(vec2(other) + 0.5)));
    float expected = slope * facing > 0.0 ? own * facing / slope : own;
    float weight = max(0.0, 1.0 - abs(found.z - expected) / (0.012 * own + 0.01));
    sum += vec3(found.xy, 1.0) * weight;
  }
  visible.xy = sum.xy / sum.z;
}
