// Multipliers to start with; see kernels/fluid_warm.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  float start = share * min(fluid_start[i].w, 0.0);
  fluid_lambda[i] = start;
  fluid_total[i] = start;
}
