// Where the ray of each sample meets the sphere.
flat in vec3 centre;
flat in vec3 colour;
sample in vec3 ray;
layout(location = 0) out vec4 seen_colour;
layout(location = 1) out vec4 seen_normal;

#include "render/frame.glsl"

void main() {
  float along2 = dot(ray, ray);
  float middle = dot(ray, centre) / along2;
  vec3 nearest = ray * middle - centre;
  float inside = sizes.x * sizes.x - dot(nearest, nearest);
  if (inside <= 0.0) discard;
  vec3 hit = ray * (middle - sqrt(inside / along2));
  float depth = dot(hit, axis.xyz);
  if (depth <= eye.w) discard;
  gl_FragDepth = depth_of(depth);
  seen_colour = vec4(sqrt(colour), 1.0);
  seen_normal = vec4((hit - centre) / sizes.x, kind_body);
}
