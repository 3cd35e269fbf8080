// Entries of the buffer `fluid_viscosity`, read by C++ and GLSL alike: nothing but definitions.
#define VISCOSITY_STOP 0       // 1: done, iterations that follow do nothing
#define VISCOSITY_ITERATIONS 1
#define VISCOSITY_FIRST 2      // sum of m u^2 at first, J
#define VISCOSITY_LEFT 3       // the last one, J
#define VISCOSITY_SPEED 4      // sum of m v*^2, J
#define VISCOSITY_STEP 5       // along the direction
#define VISCOSITY_KEEP 6       // of the last direction
#define VISCOSITY_ENTRIES 8
