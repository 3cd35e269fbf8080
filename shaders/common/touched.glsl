// Mark of the set of particles in contact, read by C++ and GLSL alike: nothing but definitions. Each has 1 to 65536 units of its
// own, and they are summed modulo 1, which is 2^23 of them: a group's sum is no more than that, and with one more sum below it
// still exact in a float. So the mark of a set is the same whatever the order of its sum, however many touch.
#define TOUCHED_UNIT 1.1920928955078125e-7
