// A square around a sphere, seen from the sun.
layout(binding = 2) uniform samplerBuffer particles;

out vec2 place; // in radii
flat out float middle, radius; // depth in the map
#include "render/frame.glsl"

const vec2 corners[6] = vec2[6](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));

void main() {
  vec3 centre = texelFetch(particles, gl_VertexID / 6).xyz;
  vec3 at = (world_to_shadow * vec4(centre, 1.0)).xyz;
  place = corners[gl_VertexID % 6];
  middle = at.z;
  radius = sizes.x / sun_up.w;
  bool sound = !(any(isnan(at)) || any(isinf(at)));
  gl_Position = sound ? vec4(2.0 * (at.xy + place * sizes.x / sun_right.w) - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}
