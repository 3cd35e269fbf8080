// What is seen of a mesh: colour and normal, turned towards the eye.
centroid in vec3 world_normal, colour;
centroid in float value;
layout(location = 0) out vec4 seen_colour;
layout(location = 1) out vec4 seen_normal;

#include "render/frame.glsl"
#include "render/colour.glsl"

uniform bool has_field; // a boundary has none

void main() {
  float len = length(world_normal);
  vec3 n = len > 0.0 ? world_normal / len : up.xyz;
  seen_colour = vec4(sqrt(has_field ? surface_colour(colour, value) : colour), 1.0);
  seen_normal = vec4(gl_FrontFacing ? n : -n, kind_body);
}
