// Bonds of fluids, read by C++ and GLSL alike: nothing but definitions.
#define ELASTIC_ROWS 2       // of the table `fluid_elastic`, groups of four a material:
#define ELASTIC_BONDS 0      //   k = 2 V b, J, 0: no bonds; a / b; share of e - e_iso that relaxation leaves in a step; V, m3
#define ELASTIC_YIELD 1      //   q of a rms of 1, fall of what is borne by e_iso, strength, its rise by plastic strain, Pa
#define FAMILY_GHOST 4294967295u
#define BOND_NEW -1.0        // in place of a rest length: not known yet
#define FIT_RIDGE 1e-4       // of a mean square of directions, of which 2/15 is an isotropic one's
#define FIT_PASSES 6
#define FULL_BONDS 0.9       // sum of weights from which on a neighbourhood counts as full, of the lattice's
#define SHORTEST_BOND 1e-30  // m, or m2: what is shorter has no direction
