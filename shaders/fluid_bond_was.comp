// Who is where, and was; see kernels/fluid_bond_was.decl.
#include "common/fluid.glsl"
#include "common/fluid_bond.glsl"

void main() {
  uint place = thread_index();
  if (place >= threads) return;
  uvec4 was = uvec4(0u);
  if (place < particle_count + ghost_count) {
    uint i = fluid_particle[place];
    uint family = FAMILY_GHOST;
    if (i < particle_count) {
      uint kind = fluid_kind[i];
      bool bonds = fluid_elastic[ELASTIC_ROWS * (kind >> FLUID_KIND_SHIFT) + ELASTIC_BONDS].x > 0.0;
      family = bonds ? (kind & FLUID_BODY) + 1u : 0u;
    }
    was = uvec4(near_place_of[i], family, i, 1u);
  }
  fluid_was[place] = was;
}
