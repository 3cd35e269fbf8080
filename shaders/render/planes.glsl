// The scene's planes: unit normal towards the free side, w: n . x of its points.
layout(std140, binding = 1) uniform plane_block {
  vec4 planes[16];
};
