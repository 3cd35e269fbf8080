// Entries of the buffer `solver` about the length of Newton's steps (Steihaug 1983, "The Conjugate Gradient Method and Trust
// Regions in Large Scale Optimization"), read by C++ and GLSL alike: nothing but definitions.
// Lengths are in the preconditioner's norm, |d|^2 = d P d, J: conjugate gradients yield it without P, since z = P^-1 r.
#define SOLVER_RADIUS 51       // that a step may have, sqrt(J); 0: any
#define SOLVER_STEP2 52        // |d|^2 of the step d found so far
#define SOLVER_STEP_ALONG 53   // d P p, p the direction
#define SOLVER_DIRECTION2 54   // |p|^2
#define SOLVER_PROMISE 55      // by which the quadratic model falls along the step, J
#define SOLVER_EDGE 56         // 0: no step is complete; 1: the last one ended inside the region, 2: at its edge
#define TRUST_LEAST 0.25       // of its promise a step that falls by less halves the region,
#define TRUST_MOST 0.5         // one from its edge that falls by more doubles it
