// A square behind which a sphere hides, six corners a particle: wide enough to cover it seen from the eye.
layout(binding = 2) uniform samplerBuffer particles; // world position; w: field
layout(binding = 3) uniform samplerBuffer colours;   // linear, a square root of it

flat out vec3 centre; // from the eye, m
flat out vec3 colour;
sample out vec3 ray;

#include "render/frame.glsl"
#include "render/colour.glsl"

const vec2 corners[6] = vec2[6](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));

void main() {
  int i = gl_VertexID / 6;
  vec4 particle = texelFetch(particles, i);
  vec3 own = texelFetch(colours, i).rgb;
  colour = surface_colour(own * own, particle.w);
  centre = particle.xyz - eye.xyz;
  float distance2 = dot(centre, centre), radius2 = sizes.x * sizes.x;
  if (!(distance2 > 1.0001 * radius2) || isinf(distance2)) { // around the eye, or no number
    ray = centre;
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  vec3 along = centre * inversesqrt(distance2);
  vec3 side = normalize(cross(along, abs(along.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0)));
  vec2 corner = corners[gl_VertexID % 6] * sqrt(radius2 * distance2 / (distance2 - radius2));
  ray = centre + corner.x * side + corner.y * cross(side, along);
  gl_Position = world_to_clip * vec4(eye.xyz + ray, 1.0);
}
