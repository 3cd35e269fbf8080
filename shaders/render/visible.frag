// How much of the sun and of the sky a pixel sees.
//   sun: percentage-closer soft shadows (Fernando 2005) against the receiver's own plane
//   sky: scalable ambient obscurance (McGuire, Mara & Luebke 2012)
// A pixel takes few samples, turned by one of sixteen angles; smooth.frag gathers sixteen pixels.
layout(binding = 7) uniform sampler2D shadow_depth;
layout(binding = 8) uniform sampler2DShadow shadow_test;
layout(location = 0) out vec4 visible; // sun, sky, depth in radii of the casters

#include "render/frame.glsl"
#include "render/seen.glsl"

const int blocker_taps = 9, shadow_taps = 10, sky_taps = 9;
const float golden = 2.39996323;
const float behind = 0.99999; // of the map: what lies farther is behind all casters alike

vec2 spiral(int i, int count, float turn) {
  float angle = golden * float(i) + turn;
  return sqrt((float(i) + 0.5) / float(count)) * vec2(cos(angle), sin(angle));
}

float sunlight(vec3 place, vec3 normal, float turn) {
  float facing = dot(normal, to_sun.xyz);
  if (facing <= 0.0) return 0.0;
  float across = sun_right.w, range = sun_up.w;
  float texel = across / float(textureSize(shadow_depth, 0).x);
  vec3 at = (world_to_shadow * vec4(place + normal * texel * 1.5, 1.0)).xyz;
  float reach = to_sun.w * at.z * range; // widest half-shadow: of what stands at the near plane
  float edge = reach / across;
  if (at.z <= 0.0 || any(lessThan(at.xy, vec2(-edge))) || any(greaterThan(at.xy, vec2(1.0 + edge)))) return 1.0;

  // Depth of the receiver's tangent plane, a unit of the map sideways.
  vec2 slope = vec2(dot(normal, sun_right.xyz), dot(normal, sun_up.xyz)) / max(facing, 0.15) * across / range;
  float slack = texel * (1.0 + 0.5 / max(facing, 0.15)) / range;
  float sum = 0.0, blockers = 0.0;
  for (int i = 0; i < blocker_taps; ++i) {
    vec2 offset = spiral(i, blocker_taps, turn) * edge;
    float depth = textureLod(shadow_depth, at.xy + offset, 0.0).r;
    if (depth < min(at.z + dot(slope, offset) - slack, behind)) {
      sum += depth;
      blockers += 1.0;
    }
  }
  if (blockers == 0.0) return 1.0;
  float wide = max(to_sun.w * (at.z - sum / blockers) * range, 1.5 * texel) / across;
  float lit = 0.0;
  for (int i = 0; i < shadow_taps; ++i) {
    vec2 offset = spiral(i, shadow_taps, turn + 1.0) * wide;
    lit += textureLod(shadow_test, vec3(at.xy + offset, min(at.z + dot(slope, offset) - slack, behind)), 0.0);
  }
  return lit / float(shadow_taps);
}

float openness(vec3 place, vec3 normal, vec2 pixel, float along, float turn) {
  float radius = sizes.y, wide = min(radius * ray_right.w / along, 0.15 * picture.y);
  if (wide < 1.5) return 1.0;
  float sum = 0.0;
  for (int i = 0; i < sky_taps; ++i) {
    vec2 other = clamp(floor(pixel + spiral(i, sky_taps, turn) * wide), vec2(0.0), picture.xy - 1.0) + 0.5;
    float depth = texelFetch(depth_samples, ivec2(other), 0).r;
    vec3 between = eye.xyz + ray_through(first_sample(other)) * depth_from(depth) - place;
    float distance2 = dot(between, between), height = dot(between, normal);
    float near = max(1.0 - distance2 / (radius * radius), 0.0);
    sum += near * near * near * max((height - 0.02 * radius) / (distance2 + 1e-3 * radius * radius), 0.0);
  }
  return max(0.0, 1.0 - 1.4 * radius * sum / float(sky_taps));
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 normal = texelFetch(normal_samples, at, 0);
  visible = vec4(1.0, 1.0, 60000.0, 0.0);
  if (normal.w == kind_sky) return;
  vec3 ray = ray_through(first_sample(gl_FragCoord.xy));
  float along = seen_depth(normal, texelFetch(depth_samples, at, 0).r, ray);
  visible.z = min(along / casters.w, 60000.0);
  vec3 place = eye.xyz + ray * along;
  // The sixteen angles, so that neighbours differ most.
  float turn = float((at.x & 3) * 4 + (at.y & 3) * 7 + ((at.x >> 1) & 1) * 2 & 15) * (pi / 8.0);
  visible.x = sunlight(place, normal.xyz, turn);
  if (normal.w == kind_body || distance(place, casters.xyz) < casters.w + sizes.y)
    visible.y = openness(place, normal.xyz, gl_FragCoord.xy, along, turn);
}
