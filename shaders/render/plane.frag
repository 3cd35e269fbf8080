// Marks a plane; resolve.frag paints it.
uniform vec4 plane_normal; // w: its number
layout(location = 0) out vec4 seen_colour;
layout(location = 1) out vec4 seen_normal;

#include "render/frame.glsl"

void main() {
  seen_colour = vec4(sqrt(vec3(0.5)), 1.0);
  seen_normal = vec4(plane_normal.xyz, kind_plane + plane_normal.w);
}
