// Numbers of the spreading of particles, read by C++ and GLSL alike: nothing but definitions. Measured: whole blocks keep
// their size over hundreds of iterations with these, and grow by a quarter without the two on neighbours.
#define SURFACE_COVER 0.85   // of a full neighbourhood: jittered by .2 spacings, inside there are .88 and more, on a plane .84 and less
#define SURFACE_FULL 0.5     // length of a mean normal from which all that leads along it is left out
#define SPREAD_NEAR 1.2      // spacings: neighbours up to here push particles that have some of the surface near,
#define SPREAD_FAR 1.6       //   from here on they do not
#define SPREAD_APART 0.8     // spacings: closer pairs part where there is surface tension,
#define SPREAD_APART_RATE 0.25 // by this share of what is missing, each
