// Light on a surface: sun with a GGX highlight (Walter et al. 2007, Schlick's Fresnel term), hemisphere of sky and
// ground. Colours are linear; a white surface that faces the sun is near 1.
#include "render/sky.glsl"

const float roughness = 0.42;

vec3 shade(vec3 albedo, vec3 normal, vec3 towards_eye, float sunlit, float open) {
  float facing = dot(normal, to_sun.xyz), view = max(dot(normal, towards_eye), 0.12); // smooth normals may look away
  vec3 halfway = normalize(to_sun.xyz + towards_eye);
  float n_h = max(dot(normal, halfway), 0.0), v_h = max(dot(towards_eye, halfway), 0.0);
  float light = max(facing, 0.0);
  float a2 = roughness * roughness * roughness * roughness;
  float lobe = n_h * n_h * (a2 - 1.0) + 1.0;
  float k = 0.5 * roughness * roughness;
  float masking = 0.25 / ((light * (1.0 - k) + k) * (view * (1.0 - k) + k));
  float highlight = a2 / (pi * lobe * lobe) * masking * (0.04 + 0.96 * pow(1.0 - v_h, 5.0));
  vec3 colour = sun_colour * light * sunlit * (albedo + 0.5 * pi * highlight);

  float above = 0.5 + 0.5 * dot(normal, up.xyz);
  vec3 around = mix(bounce, mix(haze, zenith, 0.4), above);
  colour += albedo * around * open * 0.62;

  vec3 mirrored = reflect(-towards_eye, normal);
  float glance = 0.04 + 0.14 * pow(1.0 - view, 5.0);
  float lifted = smoothstep(-0.35, 0.35, dot(mirrored, up.xyz));
  colour += mix(bounce, sky(mirrored), lifted) * glance * open * open * 0.6;
  return colour;
}

// Compresses what is brighter than white can show and leaves the rest as it is, so that a colour of the scene stays
// itself (after the Khronos PBR neutral tone mapper, 2024).
vec3 tone(vec3 colour) {
  const float start = 0.76, fading = 0.15;
  float peak = max(colour.r, max(colour.g, colour.b));
  if (peak <= start) return colour;
  float room = 1.0 - start;
  float shown = 1.0 - room * room / (peak + room - start);
  colour *= shown / peak;
  float pale = 1.0 - 1.0 / (fading * (peak - shown) + 1.0);
  return mix(colour, vec3(shown), pale);
}

vec3 to_srgb(vec3 linear) {
  linear = clamp(linear, 0.0, 1.0);
  return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, greaterThan(linear, vec3(0.0031308)));
}
