// Entries of the buffer `solver`, read by C++ and GLSL alike: nothing but definitions.
#define SOLVER_STOP 0          // 1: done, iterations that follow do nothing
#define SOLVER_ACTION 1        // 0 nothing, 1 keep the best, 2 restore it
#define SOLVER_START 2         // iteration of the last restart
#define SOLVER_ONE_MINUS_RHO 3 // of the spectral radius in use
#define SOLVER_GAMMA 4         // under-relaxation in use
#define SOLVER_FIRST 5         // residual at the start, sqrt(N m)
#define SOLVER_BEST 6          // smallest residual so far
#define SOLVER_CURRENT 7       // residual at the last check
#define SOLVER_RESTARTS 8
#define SOLVER_ITERATIONS 9    // force evaluations that led to the best iterate
#define SOLVER_REASON 10       // 1 tolerance, 2 floor, 3 cap
#define SOLVER_DELAY 11        // plain iterations before acceleration
#define SOLVER_ACCELERATE 12
#define SOLVER_ENTRIES 16
