// Contacts on both sides or on neither; see kernels/contact_mutual.decl.
#include "common/bonds.glsl"
#include "common/contact.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads || left_out[0] == 0u) return;
  uint base = CONTACTS * SLICE * (i / SLICE) + i % SLICE;
  for (uint a = 0u; a < CONTACTS; ++a) {
    uint j = contact[base + SLICE * a];
    if (j == i) break;
    uint back = CONTACTS * SLICE * (j / SLICE) + j % SLICE, b = 0u;
    for (; b < CONTACTS; ++b) {
      // Others may be setting the mark of this entry: it does not matter here.
      uint other = atomicOr(contact[back + SLICE * b], 0u) & ~CONTACT_DROPPED;
      if (other == i || other == j) break;
    }
    if (b == CONTACTS) atomicOr(contact[base + SLICE * a], CONTACT_DROPPED);
  }
}
