// Entries of the buffer `solver`, read by C++ and GLSL alike: nothing but definitions.
#define SOLVER_STOP 0          // 1: done, iterations that follow do nothing; 1/2: nothing to evaluate in this iteration
#define SOLVER_ACTION 1        // 0 nothing, 1 keep the best, 2 restore it
#define SOLVER_START 2         // iteration of the last restart
#define SOLVER_ONE_MINUS_RHO 3 // of the spectral radius in use
#define SOLVER_GAMMA 4         // under-relaxation in use
#define SOLVER_FIRST 5         // residual at the start, sqrt(N m)
#define SOLVER_BEST 6          // smallest residual so far
#define SOLVER_CURRENT 7       // residual at the last check
#define SOLVER_RESTARTS 8
#define SOLVER_ITERATIONS 9    // force evaluations that led to the best iterate
#define SOLVER_REASON 10       // 1 tolerance, 2 floor, 3 cap, 4 no descent that the precision can tell
#define SOLVER_DELAY 11        // plain iterations before acceleration
#define SOLVER_ACCELERATE 12
// Methods with a line search:
#define SOLVER_LINEAR 13       // 1: kernels that work on a direction run in this iteration
#define SOLVER_TAKEN 14        // 1: the line search took the iterate of this iteration
#define SOLVER_LENGTH 15       // of the step that is tried, 1 at first
#define SOLVER_FACTOR 16       // by which it is cut
#define SOLVER_POTENTIAL 17    // at the best iterate, J
#define SOLVER_SLOPE 18        // r . d: how fast the potential falls along the whole step, J
#define SOLVER_CUTS 19         // of this line search
#define SOLVER_RETURN 20       // 1: the next evaluation is at the best iterate again
#define SOLVER_CAUTIOUS 21     // 1: the last search failed, only the preconditioned gradient is tried
#define SOLVER_COUNT 22        // force evaluations and products of the derivative so far
#define SOLVER_INNER 23        // conjugate gradient iterations of this Newton step
#define SOLVER_RZ 24           // r . z of the last of them
#define SOLVER_RZ_ENOUGH 25    // at which they end
#define SOLVER_CG_STEP 26      // along the direction
#define SOLVER_CG_KEEP 27      // of the last direction
#define SOLVER_HISTORY 28      // steps remembered, at most MEMORY
#define SOLVER_NEWEST 29       // slot of the last of them
#define SOLVER_KEEP_Z 30       // coefficients of a quasi-Newton direction: of z,
#define SOLVER_KEEP_STEP 31    //   of each step (MEMORY),
#define SOLVER_KEEP_IMAGE 36   //   of each image (MEMORY)
#define SOLVER_SCALE 41        // of the residual that momentum alone would leave, |(m / h^2) u*| in its norm, sqrt(N m)
#define SOLVER_TRIAL 42        // 1: the other first guess, standing still, is evaluated
#define SOLVER_FLOOR 43        // what the precision can reach, sqrt(N m)
#define SOLVER_TOUCHED 44      // mark of the set of particles in contact
#define SOLVER_CONVEX 45       // residual at which the derivative was found indefinite, 0 if not: it is kept positive till .1 of it
#define SOLVER_ENTRIES 64
#define MEMORY 5               // steps that a quasi-Newton method remembers
#define HISTORY_DOTS 25        // five a slot: s.r, z.r, s.y_new, s_new.y, y.z_new
#define HISTORY_STEP 0         // rows of the buffer `history`, MEMORY each: s, the step
#define HISTORY_CHANGE 5       //   y, how the residual fell
#define HISTORY_IMAGE 10       //   z = P^-1 y
#define HISTORY_RESIDUAL 15    //   and the last residual and its image, one row each
#define HISTORY_PRECONDITIONED 16
#define HISTORY_ROWS 17
