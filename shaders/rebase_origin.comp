// A body takes its origin along; see kernels/rebase_origin.decl.

void main() {
  uint b = thread_index();
  if (b >= threads) return;
  float quantum = origin[b].w;
  vec3 shift = quantum * roundEven(position[anchor[b]].xyz / quantum);
  for (int axis = 0; axis < 3; ++axis)
    if (isnan(shift[axis]) || isinf(shift[axis])) shift[axis] = 0.0;
  origin[b].xyz += shift;
  origin_shift[b] = vec4(shift, 0.0);
}
