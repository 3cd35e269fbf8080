// An endless plane: four quarters, each from a point below the eye to two directions at infinity.
uniform vec3 foot;          // a point of the plane
uniform vec3 first, second; // unit, in the plane

#include "render/frame.glsl"

void main() {
  int quarter = gl_VertexID / 3 + (gl_VertexID % 3 == 2 ? 1 : 0);
  vec2 turn = vec2[4](vec2(1, 0), vec2(0, 1), vec2(-1, 0), vec2(0, -1))[quarter % 4];
  gl_Position = world_to_clip *
                (gl_VertexID % 3 == 0 ? vec4(foot, 1.0) : vec4(turn.x * first + turn.y * second, 0.0));
}
