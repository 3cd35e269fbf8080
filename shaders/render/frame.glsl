// What every program of the renderer shares: camera, sun and sizes of this picture. FrameBlock in frame.h mirrors it.
layout(std140, binding = 0) uniform frame_block {
  mat4 world_to_clip;   // depth reaches infinity
  mat4 world_to_shadow; // to [0, 1]^3 of the shadow map
  vec4 eye;            // m; w: distance of the near plane
  vec4 axis;           // unit, where the eye looks; w: how far right of a pixel's middle its first sample lies, pixels
  vec4 forward;        // ray through the middle of the picture, of depth 1
  vec4 ray_right;      // what one unit of normalised device x adds to the ray; w: pixels a unit of x / depth
  vec4 ray_up;         // w: how far above the middle
  vec4 to_sun;         // unit; w: tangent of the sun's angular radius
  vec4 sun_right;      // axes of the shadow map; w: m across it
  vec4 sun_up;         // w: m from its near to its far plane
  vec4 up;             // against gravity; w: m between grid lines
  vec4 casters;        // a sphere around all that casts a shadow; w: radius, m
  vec4 picture;        // width, height and their reciprocals
  vec4 sizes;          // radius of a particle, of occlusion, of the ground's fade, m; samples of a pixel
  vec4 field;          // low, 1 / (high - low), 1 where the field is drawn
};

// A pixel without anything holds 0 in w of the normal; a body 1; plane i of the scene 2 + i.
const float kind_sky = 0.0, kind_body = 1.0, kind_plane = 2.0;
const float pi = 3.14159265;

vec2 to_device(vec2 pixel) { return 2.0 * pixel * picture.zw - 1.0; }

// World vector from the eye to depth 1 through a point of the picture.
vec3 ray_through(vec2 pixel) {
  vec2 at = to_device(pixel);
  return forward.xyz + at.x * ray_right.xyz + at.y * ray_up.xyz;
}

// Where the first sample of a pixel lies.
vec2 first_sample(vec2 pixel) { return pixel + vec2(axis.w, ray_up.w); }

// Depth along the view axis, m, to the depth buffer's and back; infinity lies just before 1.
float depth_of(float along) { return 0.99999952 - eye.w / along; }
float depth_from(float depth) { return eye.w / max(0.99999952 - depth, 1e-7); }
