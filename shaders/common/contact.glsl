// Layout of the obstacle table and of contact lists, read by C++ and GLSL alike: nothing but definitions.
#define OBSTACLES 32       // at most
#define OBSTACLE_ROWS 9    // groups of four an obstacle:
#define OBSTACLE_KIND 0    //   kind, friction, how it holds, 1: particles are kept inside
#define OBSTACLE_STICKS 1  //     no-slip;
#define OBSTACLE_GHOSTS 2  //     ghosts stand for the obstacle in all but keeping fluids out; 0: by friction
#define OBSTACLE_CENTRE 1  //   centre at the end of the step, m, world; radius about it beyond which nothing touches, m
#define OBSTACLE_SIZE 2    //   box: half edges; sphere: radius; cylinder: radius, half height; torus: ring, tube; m
                           //   w: cell of the distance grid, m
#define OBSTACLE_AXES 3    //   rows of R, world = centre + R own; w: lowest corner of the distance grid, own axes, m
#define OBSTACLE_SHIFT 6   //   rows of (W, w): its displacement over the step at centre + r is W r + w, m
#define OBSTACLE_PLANE 0   // kinds; a plane's free side is its own +y, cylinder and torus stand about own y
#define OBSTACLE_SPHERE 1
#define OBSTACLE_BOX 2
#define OBSTACLE_CYLINDER 3
#define OBSTACLE_TORUS 4
#define OBSTACLE_MESH 5

#define CONTACTS 16          // kept for a particle: entry k of particle i is contact[256 (i / 16) + 16 k + i % 16]
#define CONTACT_DROPPED 2147483648u // bit of an entry whose partner's full list has no room for this particle
#define SCAN_CHUNK 2048      // cells that one group sums and scans
