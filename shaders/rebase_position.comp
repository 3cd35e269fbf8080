// Positions follow their body's origin; see kernels/rebase_position.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  position[i].xyz -= origin_shift[owner[i]].xyz;
}
