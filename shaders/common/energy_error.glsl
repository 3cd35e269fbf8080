// Entries of the buffer `solver` about the relative energy error of Xu et al. (2018), Eq. 25,
//   (Phi(q^k) - Phi(q)) / (Phi(q^0) - Phi(q)) = left / (fall + left),
// read by C++ and GLSL alike. What is left is estimated. Near the minimum it is half of r H^-1 r, H the derivative, which
// conjugate gradients from r sum up as they go, r H^-1 r = sum of their steps times r z (Hestenes and Stiefel 1952): so
// they tell what share of it the preconditioner's r P^-1 r is, which the next iterate has for nothing. A quasi-Newton
// direction d stands for H^-1 r; where it is far from that the falls of the iterations shrink slowly, and the sum of the
// series that the last two begin is the larger. Both come and go by ten times from one iteration to the next while what is
// really left shrinks by a few percent: so what was expected a few iterations ago counts still, less each time.
// The first two entries are those of the stationary methods' acceleration, which a line search has not.
#define SOLVER_RISES 3         // iterates taken though the potential rose by more than the precision can tell: none
#define SOLVER_ENERGY_ERROR 4  // estimated at the best iterate, 1 at first
#define SOLVER_FALL 46         // of the potential so far, J
#define SOLVER_LAST_FALL 47    // in the last iteration
#define SOLVER_LEFT 48         // that falls which shrink as the last two did have before them, J
#define SOLVER_GAIN 49         // most that r H^-1 r was of r P^-1 r in this solve's conjugate gradients
#define SOLVER_RZ_FIRST 50     // r . z where they began
#define SOLVER_EXPECTED 51     // that a quasi-Newton method has left, by its last iterations, J
