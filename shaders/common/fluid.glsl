// Rows of the table `fluid_material`, read by C++ and GLSL alike: nothing but definitions.
#define FLUIDS 16        // materials at most
#define FLUID_ROWS 2     // groups of four a material:
#define FLUID_TRAITS 0   //   rest density, kg/m^3: the lattice's sum of the cubic spline; viscosity, Pa s; redistribution; tension
#define FLUID_LIMITS 1   //   softness of the density constraint, 1/(kg m^2): a share of sum_k |grad_k C|^2 / m_k of a full lattice;
                         //   C beyond which no more is corrected at once; what is outside: |grad rho| above this, kg/m^(d+1);
                         //   tensile strength over the square of the rest density
#define FLUID_BODY 16777215u // bits of fluid_kind that name the body; above them, the material
#define FLUID_KIND_SHIFT 24
// A particle in a nozzle has the seconds until it leaves in the w of its velocity, where others have the multiplier of the density
// constraint, which is never above 0. It leaves when less than this share of a step remains: none that a rounding decides.
#define FLUID_HELD 0.382
