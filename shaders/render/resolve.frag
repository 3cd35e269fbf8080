// Lights each pixel: once where its samples show one surface, else sample by sample.
uniform float share; // of this picture in the sum of several
layout(binding = 9) uniform sampler2D visibility;
layout(location = 0) out vec4 picture_colour;

#include "render/frame.glsl"
#include "render/seen.glsl"
#include "render/shade.glsl"

// How much of a pixel that is `wide` cells wide is covered by lines at whole numbers of cells.
float line(float at, float wide, float thick) {
  float half_width = 0.5 * (wide + thick);
  float off = abs(fract(at + 0.5) - 0.5);
  float cover = clamp((half_width - off) / max(wide, 1e-6), 0.0, min(1.0, thick / max(wide, 1e-6)));
  return mix(cover, thick, smoothstep(0.3, 0.7, wide));
}

// A squares pattern, averaged over a pixel (box filter).
float squares(vec2 at, vec2 wide) {
  vec2 low = (at - 0.5 * wide) * 0.5, high = (at + 0.5 * wide) * 0.5;
  vec2 a = abs(fract(low) - 0.5), b = abs(fract(high) - 0.5);
  vec2 mean = 2.0 * (a - b) / max(wide * 0.5, vec2(1e-6));
  mean = mix(clamp(mean, -1.0, 1.0), vec2(0.0), smoothstep(0.6, 1.2, wide));
  return 0.5 + 0.5 * mean.x * mean.y;
}

vec3 plane_colour(vec3 place, vec3 normal, vec3 ray, float along) {
  vec3 side = abs(normal.x) < 0.7 ? vec3(1, 0, 0) : vec3(0, 0, 1);
  vec3 first = normalize(side - normal * dot(side, normal)), second = cross(normal, first);
  vec2 at = vec2(dot(place, first), dot(place, second)) / up.w;
  // What one pixel covers, in cells: the ray's footprint, stretched where it grazes.
  float pixel = along / (ray_right.w * up.w), graze = max(abs(dot(normal, normalize(ray))), 1e-4);
  vec2 heading = normalize(vec2(dot(ray, first), dot(ray, second)) + 1e-6);
  vec2 wide = pixel * sqrt(heading.yx * heading.yx + heading * heading / (graze * graze));
  vec3 colour = mix(vec3(0.355, 0.35, 0.345), vec3(0.40, 0.395, 0.385), squares(at, wide));
  float lines = max(line(at.x, wide.x, 0.012), line(at.y, wide.y, 0.012));
  return colour * (1.0 - 0.22 * lines);
}

const ivec2 around[5] = ivec2[5](ivec2(0), ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));

vec3 lit(ivec2 at, vec3 ray, vec4 normal, float depth, vec3 colour, bool edge) {
  if (normal.w == kind_sky) {
    vec3 towards = normalize(ray);
    return sky(towards);
  }
  float along = seen_depth(normal, depth, ray);
  vec3 place = eye.xyz + ray * along;
  vec4 visible = texelFetch(visibility, at, 0);
  if (edge) { // of the pixels around, the one that shows most nearly this surface
    float least = 1e9;
    for (int i = 0; i < 5; ++i) {
      ivec2 other = clamp(at + around[i], ivec2(0), ivec2(picture.xy) - 1);
      vec4 its_normal = texelFetch(normal_samples, other, 0), found = texelFetch(visibility, other, 0);
      float off = 20.0 * abs(found.z * casters.w / along - 1.0) + distance(its_normal.xyz, normal.xyz);
      off += its_normal.w == normal.w ? 0.0 : 4.0;
      if (off < least) {
        least = off;
        visible = found;
      }
    }
  }
  bool plane = normal.w >= kind_plane;
  if (plane) colour = plane_colour(place, normal.xyz, ray, along);
  vec3 shown = shade(colour, normalize(normal.xyz), -normalize(ray), visible.x, visible.y);
  if (plane) {
    float far = length(place - casters.xyz) / sizes.z;
    shown = mix(shown, sky(normalize(ray - up.xyz * min(dot(ray, up.xyz), 0.0))), 1.0 - exp(-far * far));
  }
  return shown;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  int samples = int(sizes.w);
  vec3 ray = ray_through(gl_FragCoord.xy);
  vec4 normal = texelFetch(normal_samples, at, 0);
  bool edge = false;
  for (int i = 1; i < samples; ++i) {
    vec4 other = texelFetch(normal_samples, at, i);
    if (other.w != normal.w || distance(other.xyz, normal.xyz) > 0.35) edge = true;
  }
  vec3 result = vec3(0.0);
  if (!edge) {
    vec3 colour = vec3(0.0);
    float depth = 0.0;
    if (normal.w == kind_body) {
      for (int i = 0; i < samples; ++i) colour += texelFetch(colour_samples, at, i).rgb;
      colour /= float(samples);
      depth = texelFetch(depth_samples, at, 0).r;
    }
    result = to_srgb(tone(lit(at, ray, normal, depth, colour * colour, false)));
  } else {
    for (int i = 0; i < samples; ++i) {
      vec3 colour = texelFetch(colour_samples, at, i).rgb;
      float depth = texelFetch(depth_samples, at, i).r;
      result += tone(lit(at, ray, texelFetch(normal_samples, at, i), depth, colour * colour, true));
    }
    result = to_srgb(result / float(samples));
  }
  // Half a step of the picture's 255, so that the sky shows no bands.
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  picture_colour = vec4((result + noise / 255.0) * share, share);
}
