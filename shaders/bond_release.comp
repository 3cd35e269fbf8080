// Energy of broken bonds; see kernels/bond_release.decl.

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  released[i] += before[i] - energy[i];
}
