// A corner of a mesh: position and normal as normals.comp left them, moved as a whole.
layout(location = 0) in vec4 position; // w: field
layout(location = 1) in vec4 normal;
layout(location = 2) in vec3 own_colour; // linear

uniform mat4 move;
uniform bool shadow; // seen from the sun

centroid out vec3 world_normal, colour; // a pixel at a silhouette must not extrapolate
centroid out float value;

#include "render/frame.glsl"

void main() {
  vec4 world = move * vec4(position.xyz, 1.0);
  world_normal = mat3(move) * normal.xyz;
  colour = own_colour;
  value = position.w;
  gl_Position = shadow ? vec4(2.0 * (world_to_shadow * world).xyz - 1.0, 1.0) : world_to_clip * world;
}
