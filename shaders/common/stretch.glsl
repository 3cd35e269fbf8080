// The table `energies` of law "basis", read by C++ and GLSL alike: nothing but definitions.
#define STRETCH_MATERIALS 16 // that a scene may have of this law
#define STRETCH_POWERS 4     // rows of a sum: n, shares of A_n, B_n and (for n = 1) log2; n = 0 ends it
#define STRETCH_VOLUME 1     // first row of (lambda_2 / mu_2) g; row 0: 1 if theta is the root of the mean square
#define STRETCH_BOND 5       // first row of h
#define STRETCH_ROWS 9       // a material
#define STRETCH_LEAST 0.1    // the formulas hold from here
#define STRETCH_MOST 10.0    // to here; beyond, the derivative goes on in a straight line
